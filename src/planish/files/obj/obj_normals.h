#pragma once

#include "planish/files/shared/split_normals.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

/// The normals of an OBJ file that read_obj() has read: `vn` lines, and what `v/vt/vn` says of
/// them. Numbers that are none make no normal. Corners that name a normal which is not there have
/// none and are noted; of a strict file they throw Error{UnreadableInput}.
[[nodiscard]] CornerNormals read_obj_normals(const FileBytes& file, LineNote& missing);

}  // namespace planish
