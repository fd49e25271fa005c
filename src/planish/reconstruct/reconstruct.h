#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/statistics.h"
#include "planish/reconstruct/spatial_search.h"

namespace planish {

enum class OutlierRule {
  Off,
  Auto,      ///< as Distance with the defaults, without those that are a sparse part of the shape,
             ///< and points that stick out of the surface around them
  Distance,  ///< remove what is farther than `factor` medians from its neighbours
};

struct CleanOptions {
  OutlierRule outliers = OutlierRule::Auto;
  std::int32_t neighbour_count = 12;  ///< 1 to 100
  double factor = 2.0;                ///< positive
  Callbacks callbacks;
};

/// Share of points above which OutlierRule::Auto takes sparse points for a part of the shape in any
/// case; fewer where they lie on smooth sheets of their own.
inline constexpr double kMostOutliers = 0.05;

/// What is left of a cloud.
struct CleanPoints {
  std::vector<std::int32_t> kept;  ///< indices of the points that stay, ascending
  std::int64_t duplicate_count = 0;
  std::int64_t outlier_count = 0;  ///< far from all others
  std::int64_t stray_count = 0;    ///< off the surface around them
  double spacing = 0;  ///< median over the kept points of the mean distance to the 6 nearest
};

/// Removes all but the first of points at the same place, then outliers: points whose mean
/// distance to their nearest `neighbour_count` points exceeds `factor` times the median of that
/// distance; by OutlierRule::Auto then points whose distance to the quadratic fit of their
/// neighbours (clean.cpp) is above 5 of its standard deviations and 0.2 of the spacing. Throws
/// Error{InvalidArgument}, Error{Cancelled}. Warns "uneven-density".
[[nodiscard]] CleanPoints clean(std::span<const glm::dvec3> points,
                                const CleanOptions& options = {});

/// Which connected parts of a mesh stay.
struct ComponentRule {
  /// Auto: those of at least a fiftieth of the largest one's triangles.
  enum class Keep { Auto, Largest, All, AtLeast } keep = Keep::Auto;
  std::int64_t least_faces = 0;  ///< of Keep::AtLeast
};

struct TriangleRepairOptions {
  std::int32_t longest_filled_loop = 16;  ///< edges of a hole; 0 fills none, at most 1000
  ComponentRule components;
  Callbacks callbacks;
};

/// An oriented manifold, with or without boundary, and what was done to get it.
struct RepairedTriangles {
  std::vector<Triangle> triangles;
  std::int64_t dropped_triangle_count = 0;  ///< repeated, bridging, or against manifold
  std::int64_t filled_loop_count = 0;
  std::int64_t dropped_component_count = 0;
};

/// Makes triangles with any winding an oriented manifold: drops what prevents it and
/// open_bridges(), keeps the asked components, fills short boundary loops with the flattest patch
/// (largest dihedral angle, then area, at its least), and turns every component outwards (by its
/// volume; an open one by the volume over its centroid; one without volume as its first triangle
/// is). Corners must be different indices of `positions`. Throws Error{InvalidArgument} for the
/// options, Error{Cancelled}.
[[nodiscard]] RepairedTriangles repair_triangles(std::span<const glm::dvec3> positions,
                                                 std::vector<Triangle> triangles,
                                                 const TriangleRepairOptions& options = {});

/// A triangle mesh through some points of a cloud, and what it says of the others.
struct WitnessedMesh {
  std::vector<std::int32_t> vertex_points;  ///< the point at each vertex, ascending
  std::vector<Triangle> triangles;          ///< corners are indices of vertex_points
  /// The nearest triangle of each point of the cloud; -1 for those at a vertex and those beyond
  /// the tolerance of all triangles.
  std::vector<std::int32_t> carriers;
};

enum class Spacing {
  Adaptive,  ///< as few vertices as the tolerance allows: flat parts get large triangles
  Even,      ///< neighbouring edges of similar length and no small angles: more vertices
};

struct SimplifyOptions {
  double tolerance = 0;              ///< a length, above 0
  std::int64_t target_vertices = 0;  ///< stop there; 0: go as far as the tolerance allows
  Spacing spacing = Spacing::Adaptive;
  double least_angle = -1;        ///< degrees, 0 to 45; below 0: by spacing
  std::int32_t max_valence = -1;  ///< at least 6; below 0: by spacing
  Callbacks callbacks;
};

/// The limits that stand for "by spacing".
[[nodiscard]] double default_least_angle(Spacing spacing);
[[nodiscard]] std::int32_t default_max_valence(Spacing spacing);

struct SimplifiedMesh {
  std::vector<Triangle> triangles;  ///< corners are indices of the given positions
  std::int64_t vertex_count = 0;
  std::int64_t collapse_count = 0, flip_count = 0, move_count = 0;
  std::int64_t strayed_count = 0;  ///< points that were beyond the tolerance to begin with
};

/// Removes vertices from an oriented manifold so that every position, vertex of the given mesh or
/// not, stays within the tolerance of the mesh; those beyond it at first are counted and left out.
/// Vertices stay where they are; components, genus and boundary loops are kept; no new triangle
/// has an angle below the limit, unless those it replaces were worse.
/// Throws Error{InvalidArgument} for the options, Error{Cancelled}.
[[nodiscard]] SimplifiedMesh simplify(std::span<const glm::dvec3> positions,
                                      std::span<const Triangle> triangles,
                                      const SimplifyOptions& options);

/// The same for a mesh through some of many points, whose carriers are known: those without one are
/// left out.
[[nodiscard]] SimplifiedMesh simplify(const OrderedPoints& points, WitnessedMesh mesh,
                                      const SimplifyOptions& options);

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
  bool keeps_scan = false;  ///< for Reconstruction::scan
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
  /// The triangles through all points that were meshed, neither moved nor simplified away; empty
  /// where nobody asked to keep it.
  PolygonMesh scan;
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
