#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/doosabin/sharp_features.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The control points of a surface on level 1, for one that is no Doo-Sabin step of a cage on the
/// mesh itself. They have their own mesh, level_one_mesh(), which is a Doo-Sabin cage by itself
/// where the given mesh is closed and smooth.
struct LevelOne {
  /// The state of level 1, see Subdivision, in coordinates of `placement`. It is that of the mesh
  /// without its unused vertices.
  std::vector<glm::dvec3> state;
  Placement placement;
};

/// Throws Error{InvalidArgument} unless the state has the size that the subdivision needs.
void require_state_of(const Subdivision& subdivision, const LevelOne& level_one);

/// The polygon mesh of level 1. Its vertices are the state, in its order and in model coordinates.
/// Its faces: first those around the vertices of `mesh`, then those within its faces, then those
/// across its edges. Around a smooth vertex lies one polygon, whose centroid is the limit point;
/// between two sharp edges one polygon for each sector, closed by the segment between their curve
/// points, whose middle is the limit point; around a corner each such polygon also holds the
/// corner itself; a sharp edge has a quad on each of its sides. Vertices of valence two have none.
/// Segments of sharp curves between two polygons are tagged as creases, corners as corners. Colours
/// and groups are carried, a polygon across several groups taking that of its first face; texture
/// coordinates and holes are not: their borders run through the polygons.
/// Throws Error{UnusableMesh}, Error{InvalidArgument} as above.
[[nodiscard]] PolygonMesh level_one_mesh(const PolygonMesh& mesh, const LevelOne& level_one,
                                         const SharpFeatureOptions& sharp);

/// Limit points of the vertices of the mesh without its unused ones, from the state of level 1 and
/// in its coordinates; in double on the CPU.
[[nodiscard]] std::vector<glm::dvec3> limit_points(const Subdivision& subdivision,
                                                   std::span<const glm::dvec3> state);

/// Limit positions of the vertices of `mesh`, in double on the CPU. Unused vertices stay where they
/// are. Throws as above.
[[nodiscard]] std::vector<glm::dvec3> limit_positions(const PolygonMesh& mesh,
                                                      const LevelOne& level_one,
                                                      const SharpFeatureOptions& sharp);

}  // namespace planish
