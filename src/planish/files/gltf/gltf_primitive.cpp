// Based on: Khronos Group, "glTF 2.0 Specification", section 3.7.2 (meshes).
#include "planish/files/gltf/gltf_primitive.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "planish/core/number_text.h"

namespace planish {
namespace {

bool is_finite_place(const glm::dvec3& position) {
  return std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z);
}

}  // namespace

SourcePrimitive::SourcePrimitive(const JsonPlace& root, const JsonPlace& primitive,
                                 GltfSource& source)
    : root_(root), place_(primitive), source_(source) {
  positions_.emplace(root_, place_["attributes"]["POSITION"].integer(),
                     GltfAccessor::Use::Positions, source_);
}

std::optional<GltfAccessor> SourcePrimitive::indices() const {
  const auto place = place_.find("indices");
  if (!place) return std::nullopt;
  return GltfAccessor(root_, place->integer(), GltfAccessor::Use::Indices, source_);
}

std::optional<GltfAccessor> SourcePrimitive::attribute(std::string_view name,
                                                       GltfAccessor::Use use) const {
  const auto place = place_["attributes"].find(name);
  if (!place) return std::nullopt;
  const GltfAccessor found(root_, place->integer(), use, source_);
  if (found.count() != positions().count())
    place->fail(std::to_string(found.count()) + " elements for " +
                std::to_string(positions().count()) + " vertices");
  return found;
}

glm::dvec3 SourcePrimitive::position(std::int64_t vertex, const GltfInstance& instance) const {
  const glm::dvec3 stored = positions().position(vertex);
  const glm::dvec3 placed(instance.to_world * glm::dvec4(stored, 1.0));
  if (!is_finite_place(placed)) {
    const glm::dvec3& shown = is_finite_place(stored) ? placed : stored;
    place_["attributes"]["POSITION"].fail("vertex " + std::to_string(vertex) + " is at (" +
                                          shortest(shown.x) + ", " + shortest(shown.y) + ", " +
                                          shortest(shown.z) + ")");
  }
  return placed;
}

glm::vec4 SourcePrimitive::color(const GltfAccessor& colors, std::int64_t vertex) const {
  const glm::vec4 color = colors.color(vertex);
  // Negated, so that NaN fails too.
  const bool in_range = color.r >= 0 && color.g >= 0 && color.b >= 0 && color.a >= 0 &&
                        color.r <= 1 && color.g <= 1 && color.b <= 1 && color.a <= 1;
  if (!in_range)
    place_["attributes"]["COLOR_0"].fail("the colour of vertex " + std::to_string(vertex) +
                                         " is not within 0 and 1");
  return color;
}

// Cofactors stay finite where there is no inverse; mirrors turn their sign.
glm::dvec3 placed_normal(const glm::dvec3& normal, const GltfInstance& instance) {
  const glm::dmat3 m(instance.to_world);
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                             glm::cross(m[0], m[1]));
  const glm::dvec3 placed = cofactors * normal;
  return glm::dot(m[0], cofactors[0]) < 0 ? -placed : placed;
}

}  // namespace planish
