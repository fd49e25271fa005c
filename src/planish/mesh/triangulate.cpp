// Based on: Sutherland, Sproull and Schumacker, "A characterization of ten hidden-surface
// algorithms", 1974 (Newell's normal).
#include "planish/mesh/triangulate.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <utility>
#include <vector>

#include "planish/core/assert.h"
#include "planish/mesh/ear_clipping.h"
#include "planish/mesh/quad_cut.h"

namespace planish {
namespace {

constexpr std::array<std::uint8_t, 6> kSplitFrom0{0, 1, 2, 0, 2, 3};
constexpr std::array<std::uint8_t, 6> kSplitFrom1{0, 1, 3, 1, 2, 3};

// The polygon seen along its Newell normal, counter-clockwise.
std::vector<glm::dvec2> flatten(std::span<const std::int32_t> corners,
                                std::span<const glm::dvec3> positions) {
  // About the first corner, so that a polygon far from the origin keeps its digits.
  const glm::dvec3 origin = positions[corners[0]];
  glm::dvec3 normal(0.0);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::size_t next = i + 1 < corners.size() ? i + 1 : 0;
    normal += glm::cross(positions[corners[i]] - origin, positions[corners[next]] - origin);
  }
  // Dropping the normal's largest component keeps the order of turns, which is all that counts.
  const glm::dvec3 size = glm::abs(normal);
  const int drop = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  int u = (drop + 1) % 3, v = (drop + 2) % 3;
  if (normal[drop] < 0) std::swap(u, v);
  std::vector<glm::dvec2> flat(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 from_origin = positions[corners[i]] - origin;
    flat[i] = {from_origin[u], from_origin[v]};
  }
  return flat;
}

}  // namespace

std::array<std::uint8_t, 6> split_quad(const glm::dvec3& corner0, const glm::dvec3& corner1,
                                       const glm::dvec3& corner2, const glm::dvec3& corner3) {
  return is_cut_from_1(corner0, corner1, corner2, corner3) ? kSplitFrom1 : kSplitFrom0;
}

void triangulate(std::span<const std::int32_t> corners, std::span<const glm::dvec3> positions,
                 std::span<std::uint32_t> triangles) {
  PLANISH_ASSERT(corners.size() >= 3 && triangles.size() == 3 * (corners.size() - 2));
  if (corners.size() == 3) {
    std::copy(corners.begin(), corners.end(), triangles.begin());
    return;
  }
  if (corners.size() == 4) {
    const auto split = split_quad(positions[corners[0]], positions[corners[1]],
                                  positions[corners[2]], positions[corners[3]]);
    std::transform(split.begin(), split.end(), triangles.begin(), [&](std::uint8_t corner) {
      return static_cast<std::uint32_t>(corners[corner]);
    });
    return;
  }
  const std::vector<glm::dvec2> flat = flatten(corners, positions);
  std::uint32_t* written = triangles.data();
  for (const std::array<std::uint32_t, 3>& triangle : clip_ears(flat))
    for (const std::uint32_t place : triangle)
      *written++ = static_cast<std::uint32_t>(corners[place]);
}

}  // namespace planish
