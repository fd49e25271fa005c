#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/primal/scheme.h"
#include "planish/solve/backend.h"
#include "planish/surface/surface_blocks.h"

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

/// Splits beyond which a tessellation is refused: 4096 faces for each face of the cage.
inline constexpr int kMaxLevel = 6;

/// Throws Error{InvalidArgument} for a level outside 0 to kMaxLevel.
void require_level(int level);

struct EvaluateOptions {
  int level = 2;  ///< 0 to kMaxLevel splits into quads (triangles with Loop)
  Scheme scheme = Scheme::DooSabin;
  Weights weights = Weights::DooSabin;  ///< of Doo-Sabin
  SharpFeatureOptions sharp;
  /// Where given, one per vertex of the cage: sector angles at corners are measured on these
  /// positions (the rest pose: the input's vertices), not on the cage's.
  std::span<const glm::dvec3> rest_positions;
  /// Where given, what is sharp, in place of the two above: that of the cage's used vertices.
  std::shared_ptr<const SharpFeatures> features;
  /// Where given, what prepare_mesh() made of this cage, or of another with the same faces and
  /// tags: they are not tested and searched again.
  std::shared_ptr<const PreparedMesh> prepared;
  std::uint64_t memory_limit_bytes = 0;  ///< 0: what the machine has free
  Callbacks callbacks;
};

/// The tessellated limit surface of a control cage, with exact limit points and normals; of
/// Catmull-Clark and Loop on the host, whatever the backend. Throws Error{UnusableMesh} (also for
/// Loop where a face is no triangle), Error{InvalidArgument} for the level, Error{OutOfMemory}
/// before memory is taken, Error{Cancelled}. Warns "degenerate-normals" where tangents are parallel
/// and a facet's normal stands in.
[[nodiscard]] SurfaceMesh evaluate(const PolygonMesh& cage, Backend& backend,
                                   const EvaluateOptions& options = {});

/// The same for the Doo-Sabin surface of these control points on the topology, tags and attributes
/// of `mesh`, whose positions only serve as the rest pose. Throws as above; Error{InvalidArgument}
/// for a state of another size.
[[nodiscard]] SurfaceMesh evaluate(const PolygonMesh& mesh, const LevelOne& level_one,
                                   Backend& backend, const EvaluateOptions& options = {});

/// The surface that a cage controls.
struct LimitOptions {
  Scheme scheme = Scheme::DooSabin;
  Weights weights = Weights::DooSabin;  ///< of Doo-Sabin
  SharpFeatureOptions sharp;
};

/// Limit positions of the cage's vertices in double on the CPU, whatever backend made the cage.
/// Unused vertices stay where they are. Throws Error{UnusableMesh}.
[[nodiscard]] std::vector<glm::dvec3> limit_positions(const PolygonMesh& cage,
                                                      const LimitOptions& options);

/// The same for Doo-Sabin.
[[nodiscard]] inline std::vector<glm::dvec3> limit_positions(const PolygonMesh& cage,
                                                             Weights weights,
                                                             const SharpFeatureOptions& sharp) {
  return limit_positions(cage, {Scheme::DooSabin, weights, sharp});
}

}  // namespace planish
