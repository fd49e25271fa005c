#include "planish/files/gltf/position_grid.h"

#include <algorithm>
#include <cmath>
#include <glm/vector_relational.hpp>

namespace planish {
namespace {

constexpr double kMostShort = 65535;
constexpr double kMostMantissas = 2.0 * ((1 << 23) - 1);  // with a sign
// A node's translation that is within this of zero everywhere is left out by glTF-Transform, and by
// what is built on it.
constexpr double kLeastTranslation = 1e-5;

double extent_of(const FloatBox& all) {
  const glm::dvec3 sides = glm::dvec3(all.maximum) - glm::dvec3(all.minimum);
  return std::max({sides.x, sides.y, sides.z});
}

PositionGrid placed_grid(const FloatBox& all, const GltfOptions& options) {
  const glm::dvec3 least(all.minimum), sides = glm::dvec3(all.maximum) - least;
  const bool packs = options.compression == GltfCompression::Meshopt;
  if (options.grid_step > 0) {
    if (packs) return {glm::dvec3(0.0), options.grid_step};
    const double reach = std::ldexp(options.grid_step, 15);
    const bool fits = glm::all(glm::greaterThanEqual(least, glm::dvec3(-reach))) &&
                      glm::all(glm::lessThan(glm::dvec3(all.maximum), glm::dvec3(reach)));
    return fits ? PositionGrid{glm::dvec3(-reach), options.grid_step} : PositionGrid{};
  }
  const double extent = extent_of(all);
  const double coarsest = coarsest_step(options.position_error);
  const double step = packs ? coarsest : extent / kMostShort;
  if (!(step > 0) || step > coarsest || extent > kMostMantissas * step) return {};
  return {packs ? least + 0.5 * sides : least, step};
}

bool is_dropped(const glm::dvec3& translation) {
  return glm::all(glm::lessThanEqual(glm::abs(translation), glm::dvec3(kLeastTranslation)));
}

}  // namespace

double coarsest_step(double error) { return 2 / std::sqrt(3.0) * error; }

// Where its place would be lost the grid lies about zero: 16 bits, which have no sign, do not do
// then.
PositionGrid position_grid(const FloatBox& all, const GltfOptions& options) {
  const PositionGrid grid = placed_grid(all, options);
  if (grid.origin == glm::dvec3(0.0) || !is_dropped(grid.origin) || !is_dropped(options.origin))
    return grid;
  const glm::vec3 farthest = glm::max(glm::abs(all.minimum), glm::abs(all.maximum));
  const double reach = std::max({farthest.x, farthest.y, farthest.z});
  const bool fits =
      options.compression == GltfCompression::Meshopt && 2 * reach <= kMostMantissas * grid.step;
  return fits ? PositionGrid{.step = grid.step} : PositionGrid{};
}

void tell_kept_float(const GltfOptions& options, const FloatBox& bounds) {
  if (!options.kept_float || options.compression != GltfCompression::Quantize ||
      position_grid(bounds, options).step > 0)
    return;
  const bool is_for_place = placed_grid(bounds, options).step > 0;
  options.kept_float(is_for_place ? 0 : std::sqrt(3.0) / 2 * extent_of(bounds) / kMostShort);
}

}  // namespace planish
