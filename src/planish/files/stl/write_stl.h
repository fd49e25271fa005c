#pragma once

#include "planish/files/polygon_stream.h"

namespace planish {

/// Binary STL: float32 triangles, as glTF has them (mesh/triangulate.h), with the normals of their
/// planes, (0, 0, 0) where they have no area. Throws Error{InvalidArgument} for 2^32 triangles.
void write_stl(const PolygonStream& stream);

}  // namespace planish
