#pragma once

#include <cstdint>

#include "planish/brep/brep.h"

namespace planish {

/// What makes shells and solids valid: each edge is used once each way (once at a boundary), each
/// loop is the border of its face's parameters, once around and counter-clockwise, and edges lie on
/// both faces and end at their vertices within what files say to be one place.
struct BrepCheck {
  std::int64_t broken_loops = 0;     ///< by face
  std::int64_t unmatched_edges = 0;  ///< used otherwise than once each way
  double largest_gap = 0;            ///< of edges from faces and vertices, of the diagonal: at most
  glm::dvec3 largest_gap_at{};       ///< in model coordinates

  [[nodiscard]] bool is_valid() const {
    return broken_loops == 0 && unmatched_edges == 0 && largest_gap <= Brep::kSamePlace;
  }
};

/// Measured on the faces and edges themselves, not on what they were made of. What it does not look
/// at: whether faces cross one another, or a face itself, in space. The same bits for every number
/// of threads.
[[nodiscard]] BrepCheck check_brep(const Brep& brep, double diagonal);

}  // namespace planish
