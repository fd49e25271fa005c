#pragma once

#include "planish/files/polygon_stream.h"

namespace planish {

/// USD as text: one Mesh with normals, colours (displayColor, displayOpacity), texture coordinates
/// (st), fields (primvars) and a GeomSubset for each group, bound to its material where that is
/// known (usd_materials.h). Numbers are shortest round-trip text of the float32 that the format
/// has. A view with a subdivision is written as the cage of its scheme with creases, corners and
/// holes, so that readers draw the limit surface themselves.
void write_usda(const PolygonStream& stream);

}  // namespace planish
