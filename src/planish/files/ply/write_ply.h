#pragma once

#include "planish/files/shared/file_buffer.h"
#include "planish/files/write_polygons.h"

namespace planish {

/// PLY: binary little endian, double positions, float `nx ny nz` for normals, sRGB colours of 8
/// bits.
void write_ply(FileBuffer& out, const PolygonPiece& piece);
[[nodiscard]] bool is_ply_part(PolygonPart part);

}  // namespace planish
