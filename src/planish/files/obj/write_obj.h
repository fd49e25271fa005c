#pragma once

#include "planish/files/shared/file_buffer.h"
#include "planish/files/write_polygons.h"

namespace planish {

/// OBJ: `vn` for normals, `vt`, `g`, `usemtl`, colours in sRGB behind the positions, `t` tags for
/// creases, corners and holes. Names lose what OBJ cannot hold: control characters, `#` before a
/// word, `\` at the end. Holds all that a mesh has, so that reading it gives the same mesh.
void write_obj(FileBuffer& out, const PolygonPiece& piece);
[[nodiscard]] bool is_obj_part(PolygonPart part);

}  // namespace planish
