#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/core/json_fwd.h"

namespace planish {

inline constexpr const char* kLodExtension = "MSFT_lod";

/// A mesh that stands for another, and how its nodes place it.
struct MeshLevel {
  std::int64_t mesh = 0;  ///< in the document
  double scale = 1;       ///< of the grid of compressed positions
  glm::dvec3 translation{0.0};
  double least_coverage = 0;  ///< of the screen, down to which it is shown

  [[nodiscard]] bool is_placed() const { return scale != 1 || translation != glm::dvec3(0.0); }
};

/// Lets every node of a mesh show `levels` in its place, of which the first has the mesh's number:
/// a single one is the node's own, or a child's where it is scaled; several are levels of detail by
/// MSFT_lod, finest first. Those of a node without a skin become children, so that the node's own
/// children and its animation move all of them; those of a skinned one, whose place means nothing,
/// stand beside it. Skin, weights and instances come to each, animations of weights, too. New nodes
/// follow those that there are. Throws Error{InvalidArgument} where a node has levels of detail
/// already, naming it.
/// Based on: Microsoft, "MSFT_lod", glTF 2.0 vendor extension.
void place_levels(nlohmann::json& document, std::span<const MeshLevel> levels);

}  // namespace planish
