#pragma once

#include "planish/edit/editor.h"

namespace planish {

/// Throws Error{InvalidArgument} where an Editor cannot take a fit, with what to do instead.
void require_editable(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options);

/// Throws Error{InvalidArgument} for moves of vertices that are not there, or to where the surface
/// would lose digits.
void require_moves(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> positions,
                   std::int32_t vertex_count, const Placement& placement);

}  // namespace planish
