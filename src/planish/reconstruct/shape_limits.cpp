#include "planish/reconstruct/shape_limits.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace planish {

void TriangleQuality::take_worst(const TriangleQuality& other) {
  largest_cosine = std::max(largest_cosine, other.largest_cosine);
  facing = std::min(facing, other.facing);
  longest_squared = std::max(longest_squared, other.longest_squared);
  shortest_squared = std::min(shortest_squared, other.shortest_squared);
}

ShapeJudge::ShapeJudge(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles)
    : positions_(positions), normals_(positions.size(), glm::vec3(0.0f)) {
  std::vector<glm::dvec3> sums(positions.size(), glm::dvec3(0.0));
  for (const Triangle& t : triangles) {
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 b = positions[t[(i + 1) % 3]] - positions[t[i]];
      const glm::dvec3 c = positions[t[(i + 2) % 3]] - positions[t[i]];
      const glm::dvec3 cross = glm::cross(b, c);
      const double length = glm::length(cross);
      if (length > 0) sums[t[i]] += std::atan2(length, glm::dot(b, c)) / length * cross;
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const double length = glm::length(sums[v]);
    if (length > 0) normals_[v] = glm::vec3(sums[v] / length);
  }
}

TriangleQuality ShapeJudge::quality(const JudgedCorner& a, const JudgedCorner& b,
                                    const JudgedCorner& c) const {
  const glm::dvec3 ab = b.place - a.place, bc = c.place - b.place, ca = a.place - c.place;
  const double ab2 = glm::dot(ab, ab), bc2 = glm::dot(bc, bc), ca2 = glm::dot(ca, ca);
  const glm::dvec3 cross = glm::cross(ab, -ca);
  const double doubled_area = glm::length(cross);
  TriangleQuality quality{.largest_cosine = 1, .facing = -1};
  quality.longest_squared = std::max({ab2, bc2, ca2});
  quality.shortest_squared = std::min({ab2, bc2, ca2});
  if (!(doubled_area > 0)) return quality;
  // The smallest angle lies opposite the shortest edge, between the two others.
  const double dot = 0.5 * (ab2 + bc2 + ca2 - 2 * quality.shortest_squared);
  quality.largest_cosine = dot / std::sqrt(dot * dot + doubled_area * doubled_area);
  quality.facing = 1;
  for (const glm::vec3& corner_normal : {a.normal, b.normal, c.normal}) {
    const glm::dvec3 normal(corner_normal);
    if (normal != glm::dvec3(0.0))
      quality.facing = std::min(quality.facing, glm::dot(cross, normal) / doubled_area);
  }
  return quality;
}

double ShapeJudge::deviation(std::int32_t a, std::int32_t b, std::int32_t c) const {
  const glm::dvec3 cross = glm::cross(positions_[b] - positions_[a], positions_[c] - positions_[a]);
  const glm::vec3 sum = normals_[a] + normals_[b] + normals_[c];
  return glm::length(cross) - glm::dot(cross, glm::dvec3(sum)) / 3;
}

}  // namespace planish
