// Based on: the first step of "Smooth Surface Reconstruction using Doo-Sabin Subdivision
// Surfaces": an approximating mesh within a tolerance of every point, vertices a subset of them.
#include "planish/reconstruct/reconstruct.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/mesh/check.h"
#include "planish/mesh/pair_triangles.h"
#include "planish/mesh/triangle_edges.h"
#include "planish/mesh/used_vertices.h"
#include "planish/reconstruct/chosen.h"
#include "planish/reconstruct/smooth_points.h"
#include "planish/reconstruct/turn_by_normals.h"

namespace planish {
namespace {

constexpr std::int32_t kMostSmoothRounds = 100;
constexpr std::size_t kFewestPoints = 4;
constexpr double kDefaultTolerance = 1e-4;
// Noise in spacings, up to which one round of smoothing does, and above which two do not.
constexpr double kLightSpacings = 0.08, kHeavySpacings = 0.3;
// Degrees at a corner of a quad where even spacing is asked for: it halves what is folded, and
// pairs 68 % of the triangles instead of 82 %.
constexpr double kEvenLargestAngle = 130;

// Shares of the time when the steps are done.
constexpr double kCleaned = 0.05, kSmoothed = 0.07, kMeshed = 0.4, kRepaired = 0.43,
                 kSimplified = 0.95;

class Stopwatch {
 public:
  // Milliseconds since the last call.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double passed = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return passed;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

void check_options(const ReconstructOptions& options) {
  const double tolerance = options.tolerance.value_or(0);
  if (!(tolerance >= 0) || !std::isfinite(tolerance))
    throw Error(ErrorCode::InvalidArgument,
                "tolerance-mesh: a fraction of the diagonal from 0 is needed");
  const std::int32_t rounds = options.smooth_rounds.value_or(0);
  if (rounds < 0 || rounds > kMostSmoothRounds)
    throw Error(ErrorCode::InvalidArgument, "smooth: " + std::to_string(rounds) +
                                                " rounds are asked for; 0 to " +
                                                std::to_string(kMostSmoothRounds) + " work");
}

// How often points are moved before they are meshed, unless that is asked for.
std::int32_t smooth_rounds_for(const Reconstruction& result) {
  const double spacings = result.noise / result.spacing;
  return spacings > kHeavySpacings ? 4 : spacings > kLightSpacings ? 2 : 1;
}

// How far points are moved and kept from the mesh: as asked for, or as their noise wants it.
void choose_by_noise(std::span<const glm::dvec3> points, const ReconstructOptions& options,
                     Reconstruction& result) {
  if (options.measure_noise) result.noise = measure_noise(points);
  const double noise = std::max(result.noise / result.diagonal, 0.0);
  const double asked = options.tolerance.value_or(kDefaultTolerance);
  // At tolerance 0 every point is to be a vertex, as it is.
  const bool is_noisy = noise > kDefaultTolerance && asked > 0;
  result.smooth_rounds = options.smooth_rounds.value_or(is_noisy ? smooth_rounds_for(result) : 0);
  result.tolerance = options.tolerance.value_or(is_noisy ? noise : kDefaultTolerance);
  const double sensible = (result.smooth_rounds > 0 ? 0.5 : 1.0) * noise;  // half is left
  if (is_noisy && asked < sensible && options.tolerance)
    options.callbacks.warn({.code = "tolerance-below-noise",
                            .message = "the points scatter by more than --tolerance-mesh, so that "
                                       "vertices are spent on their noise; " +
                                       std::to_string(sensible) + " would leave fewer"});
}

// What came out, said plainly: an open or broken mesh is no silent success.
void diagnose(const Reconstruction& result, const ReconstructOptions& options) {
  const Callbacks& callbacks = options.callbacks;
  const MeshStatistics& facts = result.statistics;
  if (facts.boundary_loop_count > 0)
    callbacks.warn(
        {.code = "open-mesh",
         .message = "the mesh is open: " + counted(facts.boundary_loop_count, "boundary loop") +
                    (facts.boundary_loop_count == 1 ? " is" : " are") + " left, genus " +
                    std::to_string(facts.genus) + "; --fill-holes N closes loops of up to N edges",
         .count = facts.boundary_loop_count});
  if (facts.component_count > 1)
    callbacks.warn({.code = "several-components",
                    .message = "the mesh has " + std::to_string(facts.component_count) +
                               " components; --components largest keeps one",
                    .count = facts.component_count});
  if (result.dropped_component_count > 0)
    callbacks.warn({.code = "components-dropped",
                    .message = counted(result.dropped_component_count, "smaller component") +
                               (result.dropped_component_count == 1 ? " was" : " were") +
                               " dropped; --components all keeps all",
                    .count = result.dropped_component_count});
  if (result.strayed_count > 0)
    callbacks.warn({.code = "points-left-out",
                    .message = std::to_string(result.strayed_count) + " of " +
                               counted(std::ssize(result.used_points), "point") +
                               (result.strayed_count == 1 ? " fits into no triangle and lies"
                                                          : " fit into no triangle and lie") +
                               " farther than the tolerance from the mesh",
                    .count = result.strayed_count});
  if (options.target_vertices > 0 && facts.vertex_count > options.target_vertices)
    callbacks.warn({.code = "target-not-reached",
                    .message = counted(facts.vertex_count, "vertex") + " are left of " +
                               std::to_string(options.target_vertices) +
                               " aimed at; a larger --tolerance-mesh allows fewer",
                    .count = facts.vertex_count});
}

// Drops unused points, moves the mesh to where the file has it and notes the points it came from.
void finish_mesh(const PolygonMesh& polygons, const PointCloud& cloud, Reconstruction& result) {
  UsedMesh used = without_unused_vertices(polygons);
  result.mesh = std::move(used.mesh);
  for (glm::dvec3& position : result.mesh.positions) position += cloud.origin;
  result.vertex_points.reserve(used.vertices.size());
  for (const std::int32_t vertex : used.vertices)
    result.vertex_points.push_back(result.used_points[vertex]);
  if (!cloud.colors.empty())
    for (const std::int32_t point : result.vertex_points)
      result.mesh.colors.push_back(cloud.colors[point]);
  require_usable(result.mesh, "reconstructed mesh");
  result.statistics = statistics(result.mesh);
}

// The cloud on its way through the steps.
struct Work {
  const PointCloud& cloud;
  const ReconstructOptions& options;
  std::vector<glm::dvec3> points;  // those used
  std::vector<Triangle> triangles;
  Reconstruction result;
  Stopwatch watch;
};

void clean_points(Work& work) {
  const Callbacks& callbacks = work.options.callbacks;
  Reconstruction& result = work.result;
  CleanOptions clean_options = work.options.clean;
  clean_options.callbacks = share_of(callbacks, 0, kCleaned);
  CleanPoints cleaned = clean(work.cloud.points, clean_options);
  result.used_points = std::move(cleaned.kept);
  result.duplicate_count = cleaned.duplicate_count;
  result.outlier_count = cleaned.outlier_count + cleaned.stray_count;
  result.spacing = cleaned.spacing;
  if (result.used_points.size() < kFewestPoints)
    throw Error(ErrorCode::UnusableMesh, counted(std::ssize(result.used_points), "point") +
                                             (result.used_points.size() == 1 ? " is" : " are") +
                                             " left after cleaning; a surface needs at least " +
                                             std::to_string(kFewestPoints));
  const auto tell_removed = [&](std::int64_t count, std::string_view one, std::string_view many) {
    if (count == 0) return;
    callbacks.warn(
        {.code = "outliers-removed",
         .message = counted(count, "point") +
                    (count == 1 ? std::string(one) + " and was" : std::string(many) + " and were") +
                    " removed; --outliers off keeps them all",
         .count = count});
  };
  tell_removed(cleaned.outlier_count, " lies far from all others", " lie far from all others");
  tell_removed(cleaned.stray_count, " sticks out of the surface around it",
               " stick out of the surface around them");
  work.points = chosen(work.cloud.points, result.used_points);
  result.diagonal = diagonal_of(work.points);
  choose_by_noise(work.points, work.options, result);
  result.timing.clean = work.watch.lap();
}

void repair(Work& work) {
  const ReconstructOptions& options = work.options;
  RepairedTriangles repaired =
      repair_triangles(work.points, std::move(work.triangles),
                       {.longest_filled_loop = options.longest_filled_loop,
                        .components = options.components,
                        .callbacks = share_of(options.callbacks, kMeshed, kRepaired)});
  work.triangles = std::move(repaired.triangles);
  work.result.filled_loop_count = repaired.filled_loop_count;
  work.result.dropped_component_count = repaired.dropped_component_count;
  if (!work.cloud.normals.empty())
    work.result.turned_component_count = turn_by_normals(
        work.points, chosen(work.cloud.normals, work.result.used_points), work.triangles);
  if (work.triangles.empty())
    throw Error(ErrorCode::UnusableMesh,
                "no surface was found in " + counted(std::ssize(work.points), "point"));
  work.result.timing.repair = work.watch.lap();
}

void simplify_within_tolerance(Work& work) {
  const ReconstructOptions& options = work.options;
  if (work.result.tolerance > 0) {
    SimplifiedMesh simplified =
        simplify(work.points, work.triangles,
                 {.tolerance = work.result.tolerance * work.result.diagonal,
                  .target_vertices = options.target_vertices,
                  .spacing = options.spacing,
                  .least_angle = options.least_angle,
                  .max_valence = options.max_valence,
                  .callbacks = share_of(options.callbacks, kRepaired, kSimplified)});
    work.triangles = std::move(simplified.triangles);
    work.result.strayed_count = simplified.strayed_count;
  }
  work.result.timing.simplify = work.watch.lap();
}

void measure_and_pair(Work& work) {
  Reconstruction& result = work.result;
  result.distances = measure_distances(work.points, work.points, work.triangles);
  PolygonMesh polygons;
  if (work.options.pair_quads) {
    const bool even = work.options.spacing == Spacing::Even;
    polygons =
        pair_triangles(work.points, work.triangles,
                       even ? PairOptions{.largest_angle = kEvenLargestAngle} : PairOptions{});
  } else {
    polygons = polygons_of(work.triangles);
    polygons.positions = std::move(work.points);
  }
  finish_mesh(polygons, work.cloud, result);
  result.timing.measure = work.watch.lap();
}

}  // namespace

Reconstruction reconstruct(const PointCloud& cloud, const Mesher& mesher,
                           const ReconstructOptions& options) {
  check_options(options);
  const HostScope host(options.callbacks);
  Work work{.cloud = cloud, .options = options};
  clean_points(work);
  // Whoever asks for it has every point moved.
  const double noise = options.smooth_rounds ? 0 : work.result.noise;
  if (work.result.smooth_rounds > 0)
    work.points = smooth_points(work.points, work.result.smooth_rounds, noise,
                                share_of(options.callbacks, kCleaned, kSmoothed));
  work.result.timing.smooth = work.watch.lap();
  work.triangles =
      mesher(work.points, share_of(options.callbacks, kSmoothed, kMeshed));  // through all points
  work.result.timing.mesh = work.watch.lap();
  repair(work);
  simplify_within_tolerance(work);
  options.callbacks.report("pair", kSimplified);
  measure_and_pair(work);
  options.callbacks.report("pair", 1);
  diagnose(work.result, options);
  return std::move(work.result);
}

}  // namespace planish
