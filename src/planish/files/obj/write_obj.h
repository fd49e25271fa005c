#pragma once

#include <array>

#include "planish/files/polygon_stream.h"

namespace planish {

inline constexpr std::array kObjParts = {PolygonPart::Head,  PolygonPart::Positions,
                                         PolygonPart::Uvs,   PolygonPart::Normals,
                                         PolygonPart::Faces, PolygonPart::Tail};

/// OBJ: `vn` for normals, `vt`, `g`, `usemtl`, colours in sRGB behind the positions, `t` tags for
/// creases, corners and holes. Names lose what OBJ cannot hold: control characters, `#` before a
/// word, `\` at the end. Holds all that a mesh has, so that reading it gives the same mesh.
void write_obj(const PolygonStream& stream);

}  // namespace planish
