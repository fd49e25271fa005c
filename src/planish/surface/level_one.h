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
/// where the given mesh is closed, smooth and without holes.
struct LevelOne {
  /// The state of level 1, see Subdivision, in coordinates of `placement`. It is that of the mesh
  /// without its unused vertices.
  std::vector<glm::dvec3> state;
  Placement placement;
};

/// Throws Error{InvalidArgument} unless the state has so many points.
void require_state_size(std::int64_t size, const LevelOne& level_one);

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
