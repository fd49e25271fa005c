#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/reconstruct/collapse_mesh.h"

namespace planish {

/// An edge less and an edge more at a vertex, named by their other ends; -1: none.
struct EdgeChange {
  std::int32_t without = -1, with = -1;
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
  /// Whether collapsing the vertex of `fan` into its ring's entry `target` keeps all of the ring.
  [[nodiscard]] bool keeps_all(std::int32_t vertex, const Fan& fan, std::size_t target) const;

  /// Whether putting a sample in the place of the vertex of `fan` keeps both it and all of the
  /// ring.
  [[nodiscard]] bool keeps_replaced(std::int32_t vertex, std::int32_t sample, const Fan& fan) const;

 private:
  [[nodiscard]] double squared_ratio(std::int32_t vertex, const EdgeChange& change) const;

  std::span<const glm::dvec3> positions_;
  const CollapseMesh& mesh_;
  double largest_squared_ratio_;
};

}  // namespace planish
