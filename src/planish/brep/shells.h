#pragma once

#include "planish/brep/brep.h"
#include "planish/brep/quad_layout.h"

namespace planish {

/// Sets the shells of faces that are joined by edges, and which of them lie inside out within
/// which. Faces, edges and places are there.
void make_shells(const MeshTopology& topology, const QuadLayout& layout, Brep& brep);

}  // namespace planish
