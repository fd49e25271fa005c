#pragma once

#include "planish/files/shared/file_buffer.h"
#include "planish/files/write_polygons.h"

namespace planish {

/// OFF: positions and faces.
void write_off(FileBuffer& out, const PolygonPiece& piece);
[[nodiscard]] bool is_off_part(PolygonPart part);

}  // namespace planish
