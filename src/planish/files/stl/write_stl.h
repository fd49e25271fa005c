#pragma once

#include "planish/files/shared/file_buffer.h"
#include "planish/files/write_polygons.h"

namespace planish {

/// Binary STL: float32 triangles, as glTF has them (gltf/triangulate.h), with the normals of their
/// planes, (0, 0, 0) where they have no area. Throws Error{InvalidArgument} for 2^32 triangles.
void write_stl(FileBuffer& out, const PolygonView& view);

}  // namespace planish
