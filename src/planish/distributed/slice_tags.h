#pragma once

#include <span>

#include "planish/distributed/mesh_slice.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Adds tags behind those of the file; the same on all ranks. Throws AgreedError{UnusableMesh} for
/// one that names no vertex.
void add_tags(const Ranks& ranks, std::span<const CreaseEdge> creases,
              std::span<const CornerVertex> corners, MeshSlice& slice);

/// Takes all tags away, as planish does where they are to be ignored.
void clear_tags(MeshSlice& slice);

}  // namespace planish
