#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/core/callbacks.h"
#include "planish/mesh/triangles.h"
#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/point_critic.h"
#include "planish/reconstruct/repair_triangles.h"
#include "planish/reconstruct/witnessed_mesh.h"

namespace planish {

struct CoarseOptions {
  double tolerance = 0;                ///< a length, above 0
  std::int64_t least_samples = 0;      ///< about so many are meshed at first, or more
  TriangleRepairOptions repair;        ///< its callbacks are not used
  std::span<const glm::vec3> normals;  ///< of the points as they were given, or empty
  Callbacks callbacks;
};

/// A mesh through few of the points that all others are near.
struct CoarseMesh {
  WitnessedMesh mesh;
  std::int64_t sample_count = 0;    ///< points meshed at first
  std::int64_t inserted_count = 0;  ///< further ones, where points were beyond the tolerance
  std::int64_t meshing_count = 0;   ///< how often samples were meshed
  std::int64_t strayed_count = 0;   ///< points beyond the tolerance all the same
  std::int64_t filled_loop_count = 0, dropped_component_count = 0, turned_component_count = 0;
};

/// Thins the points, meshes and repairs what is left, asks all points how far they are from that,
/// and meshes anew with more samples where they are beyond the tolerance. Those chosen for samples
/// are looked at first, and the outliers among them removed from `points`; so are those that
/// object. Throws Error{UnusableMesh} where there is no surface, Error{Cancelled}, and what
/// `mesher` throws.
[[nodiscard]] CoarseMesh mesh_coarse_first(OrderedPoints& points, PointCritic& critic,
                                           const Mesher& mesher, const CoarseOptions& options);

}  // namespace planish
