#pragma once

#include <span>

#include "planish/job/report.h"
#include "planish/job/scene_move.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish {

/// Moves vertices of what was fitted, one move after another, each solving what it reaches. Throws
/// Error{InvalidArgument} with the move's place: for vertices that the input has not, or that
/// became others when the mesh was mended; where the fit cannot be edited.
[[nodiscard]] MovedFigures apply_moves(FittedMesh& fitted, std::span<const SceneMove> moves);

}  // namespace planish
