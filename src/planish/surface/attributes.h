#pragma once

#include <cstdint>

#include "planish/doosabin/surface_stencils.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/stencil/quad_split.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

/// Gives a connected surface the attributes of the mesh it was refined from: texture coordinates
/// and colours linearly on the quad split (what OpenSubdiv's bilinear scheme makes of them; given
/// corners and vertices keep theirs, seams stay seams), groups by face.
void carry_attributes(const PolygonMesh& mesh, const QuadSplit& split, const LimitRows& rows,
                      SurfaceMesh& surface);

/// Faces of a surface that stem from one face of the mesh.
[[nodiscard]] std::int64_t descendant_count(std::int32_t face_size, int level);

/// Takes the descendants of the mesh's hole faces out of a surface. Vertices stay.
void remove_holes(const PolygonMesh& mesh, SurfaceMesh& surface);

}  // namespace planish
