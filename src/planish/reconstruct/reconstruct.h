#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/point_cloud.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/statistics.h"
#include "planish/mesh/triangles.h"
#include "planish/reconstruct/clean.h"
#include "planish/reconstruct/repair_triangles.h"
#include "planish/reconstruct/simplify.h"
#include "planish/reconstruct/triangle_tree.h"

namespace planish {

struct ReconstructOptions {
  /// A fraction of the diagonal of the points used; 0 keeps every point. Else 1e-4, or the noise
  /// where that is more.
  std::optional<double> tolerance;
  std::int64_t target_vertices = 0;  ///< 0: as few as the tolerance allows
  /// Of so many points and more, few are meshed at first, and further ones where any point is
  /// beyond the tolerance. All points are meshed at tolerance 0, or with many vertices for a
  /// target.
  std::int64_t coarse_from = 500'000;
  CleanOptions clean;  ///< its callbacks are not used, nor those of the members below
  std::optional<std::int32_t> smooth_rounds;  ///< 0 to 100; else 2 for noisy points, 0 for others
  bool measure_noise = true;                  ///< false: no points count as noisy
  std::int32_t longest_filled_loop = 16;
  ComponentRule components;
  Spacing spacing = Spacing::Adaptive;
  double least_angle = -1;        ///< as in SimplifyOptions
  std::int32_t max_valence = -1;  ///< as in SimplifyOptions
  bool pair_quads = true;
  Callbacks callbacks;
};

/// How many of so many points are meshed at first: all of them, or about as many as that where few
/// are, as ReconstructOptions::coarse_from says. Thin shapes and points that object add to these.
[[nodiscard]] std::int64_t meshed_at_first(std::int64_t point_count,
                                           const ReconstructOptions& options);

/// Wall-clock milliseconds of the steps of reconstruct().
struct ReconstructTiming {
  double clean = 0, smooth = 0, mesh = 0, repair = 0, simplify = 0, measure = 0;
};

/// What a reconstruction says of itself. Lengths are those of the cloud.
struct ReconstructionFigures {
  std::int64_t duplicate_count = 0, outlier_count = 0;
  double spacing = 0;
  double noise = -1;  ///< deviation from local fits; -1: not measured
  std::int32_t smooth_rounds = 0;
  double tolerance = 0;  ///< a fraction of the diagonal
  double diagonal = 0;
  MeshStatistics statistics;
  std::int64_t filled_loop_count = 0, dropped_component_count = 0;
  std::int64_t turned_component_count = 0;  ///< open ones, turned as the points' normals say
  std::int64_t strayed_count = 0;   ///< used points that the mesh was too far from to begin with
  std::int64_t sample_count = 0;    ///< points meshed at first; 0 where all were
  std::int64_t inserted_count = 0;  ///< meshed later, for points beyond the tolerance
  std::int64_t meshing_count = 1;   ///< how often points were meshed
  /// Of the used points (smoothed, if asked for) to the mesh, its quads cut as pair_triangles()
  /// says.
  PointDistances distances;
  ReconstructTiming timing;
};

/// A polygon mesh near every point of a cloud.
struct Reconstruction : ReconstructionFigures {
  /// All vertices are used; places are those of the file, see PointCloud, and so are colours
  /// and attributes.
  PolygonMesh mesh;
  /// The point at each vertex, an index into PointCloud::points; without smoothing both are equal
  /// to the last bit.
  std::vector<std::int32_t> vertex_points;
  std::vector<std::int32_t> used_points;  ///< what cleaning kept, ascending
};

/// Points to mesh, in the order of the paper's first step: clean, smooth on request, mesh through
/// all points, repair, simplify within the tolerance, pair triangles to quads, measure.
/// Warns "outliers-removed", "open-mesh", "several-components", "points-left-out",
/// "target-not-reached", "tolerance-below-noise", "coarse-tolerance". Throws Error{InvalidArgument}
/// for options, Error{UnusableMesh} for points that span no surface, Error{Cancelled}, and what
/// `mesher` throws.
[[nodiscard]] Reconstruction reconstruct(const PointCloud& cloud, const Mesher& mesher,
                                         const ReconstructOptions& options = {});

}  // namespace planish
