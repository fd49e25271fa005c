#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/triangles.h"

namespace planish {

/// What the shape of a triangle must not fall below.
struct TriangleQuality {
  double largest_cosine = -1;  ///< of the smallest angle; smaller is better
  double facing = 1;           ///< least cosine between its normal and a corner's; larger is better
  double longest_squared = 0, shortest_squared = 0;  ///< edges

  void take_worst(const TriangleQuality& other);
};

/// A corner of a triangle with its normal, unit or 0 for none.
struct JudgedCorner {
  glm::dvec3 place;
  glm::vec3 normal;
};

/// Measures triangles against the surface that they came from.
class ShapeJudge {
 public:
  /// Keeps the angle-weighted vertex normals of the given mesh, and the span of positions, which
  /// may change: set_normal() says what belongs to the new place.
  ShapeJudge(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles);

  [[nodiscard]] TriangleQuality quality(const JudgedCorner& a, const JudgedCorner& b,
                                        const JudgedCorner& c) const;
  [[nodiscard]] TriangleQuality quality(std::int32_t a, std::int32_t b, std::int32_t c) const {
    return quality(corner(a), corner(b), corner(c));
  }
  [[nodiscard]] JudgedCorner corner(std::int32_t vertex) const {
    return {positions_[vertex], normals_[vertex]};
  }
  /// Twice the area of a triangle times the mean over its corners of 1 - cosine of the angle
  /// between its normal and the corner's.
  [[nodiscard]] double deviation(std::int32_t a, std::int32_t b, std::int32_t c) const;
  /// Unit, or zero where the vertex has none.
  [[nodiscard]] glm::dvec3 normal(std::int32_t vertex) const {
    return glm::dvec3(normals_[vertex]);
  }
  void set_normal(std::int32_t vertex, const glm::vec3& normal) { normals_[vertex] = normal; }

 private:
  std::span<const glm::dvec3> positions_;
  std::vector<glm::vec3> normals_;  // zero where a vertex has none
};

}  // namespace planish
