#pragma once

#include "planish/distributed/mesh_slice.h"
#include "planish/files/obj/obj_part.h"

namespace planish {

/// Gives the slice, whose runs are known, what rides on the vertices, corners and faces of this
/// rank's range of an OBJ file, all ranks together: colours of vertices that have none, texture
/// coordinates, groups that go on from the ranks before. Takes it from `part`.
void settle_obj_attributes(const Ranks& ranks, ObjPart& part, MeshSlice& slice);

}  // namespace planish
