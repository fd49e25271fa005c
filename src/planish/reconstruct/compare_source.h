#pragma once

#include "planish/core/callbacks.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/reconstruct/spatial_search.h"
#include "planish/surface/quality_sum.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// How a surface differs from the shape that it stands for.
struct SourceComparison {
  SurfaceQuality quality;    ///< against the normals of the nearest source triangles
  PointDistances distances;  ///< of the surface's vertices to the source
};

/// Looks up the nearest point of the source, its polygons cut into fans, from every vertex of the
/// surface and from beside every corner of its faces: normals are compared within faces, so that
/// those on both sides of a crease find their own sides of the source. The surface is taken piece
/// by piece; the same bits for every thread count. Throws Error{UnusableMesh} for a source without
/// faces, Error{Cancelled}.
[[nodiscard]] SourceComparison compare_with_source(const SurfaceBlocks& surface,
                                                   const PolygonMesh& source,
                                                   const Callbacks& callbacks = {});

}  // namespace planish
