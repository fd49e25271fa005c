#pragma once

#include <array>

#include "planish/files/polygon_stream.h"

namespace planish {

inline constexpr std::array kPlyParts = {PolygonPart::Head, PolygonPart::Vertices,
                                         PolygonPart::Faces};

/// PLY: binary little endian, double positions, float `nx ny nz` for normals, sRGB colours of 8
/// bits. Texture coordinates are float `s t` of the vertices, which most readers know, where every
/// vertex has one; beside seams they are lists `texcoord` of the faces, of two numbers a corner, so
/// that no vertex has to be written twice. The list of a face that lacks any is empty.
void write_ply(const PolygonStream& stream);

}  // namespace planish
