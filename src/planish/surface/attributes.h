#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>

#include "planish/mesh/polygon_mesh.h"
#include "planish/stencil/sector_rows.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

/// Gives a connected surface the attributes of the mesh it was refined from: texture coordinates
/// and colours linearly (given corners and vertices keep theirs, seams stay seams), groups by face.
/// `refiner` is refined to the surface's level at least.
void carry_attributes(const PolygonMesh& mesh, const OpenSubdiv::Far::TopologyRefiner& refiner,
                      const SectorRows& rows, SurfaceMesh& surface);

/// Faces of the surface, holes in it included, that stem from one face of the mesh. They follow one
/// another in the order of the mesh's faces.
[[nodiscard]] std::int64_t descendant_count(const SurfaceMesh& surface, std::int32_t face_size);

/// Takes the descendants of the mesh's hole faces out of a surface, and the vertices
/// that no other face names.
void remove_holes(const PolygonMesh& mesh, SurfaceMesh& surface);

}  // namespace planish
