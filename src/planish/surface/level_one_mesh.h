#pragma once

#include <cstdint>
#include <vector>

#include "planish/doosabin/sharp_features.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/level_one.h"

namespace planish {

struct SubdividedMesh;

/// The polygon mesh of level 1, the cage of a fair surface. Its first vertices are the state, in
/// its order and in model coordinates. Its faces: first those around the vertices of `mesh`, then
/// those within its faces, then those across its edges. Around a smooth vertex lies one polygon,
/// whose centroid is the limit point; between two sharp edges one polygon for each sector, closed
/// by the segment between their curve points, whose middle is the limit point; around a corner each
/// such polygon also holds the corner itself; a sharp edge has a quad on each of its sides.
/// Vertices of valence two have none. Segments of sharp curves between two polygons are tagged as
/// creases, corners as corners.
/// Holes: polygons across the border of a hole are cut along it, at the limit point and at the
/// middles of their edges, which are further vertices, and the parts within are tagged. Texture
/// coordinates: see LevelOneUvs. Colours and groups are carried, a polygon across several groups
/// taking that of its first face.
/// `around`, where given, gets for each polygon what it lies around: a vertex of `mesh` (without
/// the unused ones), a face behind all vertices, an edge behind all faces.
/// Throws Error{UnusableMesh}, Error{InvalidArgument} for a state of another size.
[[nodiscard]] PolygonMesh level_one_mesh(const PolygonMesh& mesh, const LevelOne& level_one,
                                         const SharpFeatureOptions& sharp,
                                         std::vector<std::int32_t>* around = nullptr);
[[nodiscard]] PolygonMesh level_one_mesh(const SubdividedMesh& base, const LevelOne& level_one,
                                         std::vector<std::int32_t>* around = nullptr);

/// The state that a cage made by level_one_mesh() holds, in model coordinates; evaluate() makes of
/// it the surface that the cage was made from. Throws Error{InvalidArgument} for a mesh that is no
/// such cage of `mesh`: too few vertices, other faces.
[[nodiscard]] LevelOne level_one_of_cage(const PolygonMesh& mesh, const PolygonMesh& cage,
                                         const SharpFeatureOptions& sharp);

}  // namespace planish
