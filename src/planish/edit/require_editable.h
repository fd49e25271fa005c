#pragma once

#include "planish/edit/editor.h"

namespace planish {

/// Throws Error{InvalidArgument} where an Editor cannot take a fit, with what to do instead.
void require_editable(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options);

}  // namespace planish
