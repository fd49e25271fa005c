#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Three positions with what distance queries need, computed once.
struct TriangleShape {
  TriangleShape(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);
  /// Squared distance of a point to the closed triangle.
  [[nodiscard]] double squared_distance(const glm::dvec3& point) const;
  /// Barycentric coordinates of a point's foot in the plane, none below 0; thirds where the
  /// triangle has no area.
  [[nodiscard]] glm::dvec3 shares(const glm::dvec3& point) const;

  glm::dvec3 a, ab, ac;
  double abab, abac, acac, inverse_determinant;
};

inline constexpr int kPointLanes = 128;

/// Points side by side, each with the nearest of the shapes that it has been shown.
struct PointBatch {
  double x[kPointLanes], y[kPointLanes], z[kPointLanes];
  double squared_distance[kPointLanes];
  std::int32_t nearest[kPointLanes];
};

/// Takes the shape, by the name `index`, for the first `count` points that are nearer to it than to
/// any before; distances are those of TriangleShape::squared_distance() to the last bit.
void take_nearer(const TriangleShape& shape, std::int32_t index, int count, PointBatch& points);

/// Points in the order of a Z-curve (point_tree.h), so that neighbours in space are neighbours
/// in memory: 12 bytes a point where all coordinates are numbers of single precision, as most files
/// hold them, else 24; and 4 for the order. Places are those given, to the last bit.
class OrderedPoints {
 public:
  explicit OrderedPoints(std::span<const glm::dvec3> points);
  [[nodiscard]] std::size_t size() const { return given_.size(); }
  [[nodiscard]] glm::dvec3 operator[](std::size_t index) const {
    return doubles_.empty() ? glm::dvec3(floats_[index]) : doubles_[index];
  }
  /// The index that a point was given with.
  [[nodiscard]] std::int32_t given(std::size_t index) const { return given_[index]; }
  [[nodiscard]] std::span<const std::int32_t> given() const { return given_; }

  /// Drops the points that are marked, one mark each; the others keep their order.
  void drop(std::span<const std::uint8_t> is_dropped);
  /// Puts every point elsewhere; the order stays.
  void move_to(std::vector<glm::dvec3> places);

 private:
  std::vector<std::int32_t> given_;
  std::vector<glm::vec3> floats_;  // one of both is empty
  std::vector<glm::dvec3> doubles_;
};

/// Drops all but the first given of points at one place; returns how many.
std::int64_t drop_duplicates(OrderedPoints& points);

/// Length of the bounding box' diagonal; 0 for no points.
[[nodiscard]] double diagonal_of(const OrderedPoints& points);

/// Finds nearest triangles (bounding-box hierarchy, split at the median of the centres). Queries
/// may run in parallel.
class TriangleTree {
 public:
  TriangleTree(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles);
  TriangleTree(const OrderedPoints& positions, std::span<const Triangle> triangles);

  struct Hit {
    double squared_distance;
    std::int32_t triangle;  ///< -1 if there are no triangles
    std::int32_t place;     ///< of the triangle in the tree: where a search nearby may start
  };
  /// `start` is the place of a triangle that is likely to be near; -1: none is known. Of triangles
  /// that are equally near it decides which is found.
  [[nodiscard]] Hit nearest(const glm::dvec3& point, std::int32_t start = -1) const;

 private:
  struct Node {
    glm::dvec3 low, high;
    std::int32_t begin, end;  // of order_
    std::int32_t right = -1;  // the left child follows its parent; -1: a leaf
  };
  void build();
  void build(std::int32_t begin, std::int32_t end, std::span<const glm::dvec3> centres);

  std::vector<std::int32_t> order_;
  std::vector<TriangleShape> shapes_;  // in the order of order_
  std::vector<Node> nodes_;
};

/// Distances of points to a surface.
struct PointDistances {
  double max = 0, rms = 0;
  std::int64_t farthest = -1;  ///< index of the point at `max`
};

/// The distance of every point to the nearest of the triangles, which must not be empty unless
/// `points` is.
[[nodiscard]] PointDistances measure_distances(std::span<const glm::dvec3> points,
                                               std::span<const glm::dvec3> positions,
                                               std::span<const Triangle> triangles);

}  // namespace planish
