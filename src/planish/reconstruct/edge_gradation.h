#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/reconstruct/collapse_mesh.h"

namespace planish {

/// An edge less at a vertex, named by its other end (-1: none), and an edge more, by the place of
/// its other end (null: none).
struct EdgeChange {
  std::int32_t without = -1;
  const glm::dvec3* with = nullptr;
};

/// Holds the ratio of the longest to the shortest edge at every vertex below a limit.
class EdgeGradation {
 public:
  /// Keeps references to both.
  EdgeGradation(std::span<const glm::dvec3> positions, const CollapseMesh& mesh,
                double largest_ratio)
      : positions_(positions), mesh_(mesh), largest_squared_ratio_(largest_ratio * largest_ratio) {}

  /// Whether a vertex stays within the ratio, or becomes no worse.
  [[nodiscard]] bool keeps(std::int32_t vertex, const EdgeChange& change) const;
  /// Whether collapsing the vertex of `fan` into its ring's entry `target` leaves all of the ring
  /// within the ratio, or within the worst that it and the vertex have.
  [[nodiscard]] bool keeps_all(std::int32_t vertex, const Fan& fan, std::size_t target) const;

  /// Whether moving the vertex of `fan` keeps both it and all of the ring.
  [[nodiscard]] bool keeps_moved(std::int32_t vertex, const glm::dvec3& place,
                                 const Fan& fan) const;

 private:
  [[nodiscard]] double squared_ratio(std::int32_t vertex, const EdgeChange& change) const;

  std::span<const glm::dvec3> positions_;
  const CollapseMesh& mesh_;
  double largest_squared_ratio_;
};

}  // namespace planish
