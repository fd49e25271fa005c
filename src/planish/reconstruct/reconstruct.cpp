#include "planish/reconstruct/reconstruct.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/mesh/check.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/quads/pair_triangles.h"
#include "planish/reconstruct/reconstruct_steps.h"
#include "planish/reconstruct/spatial_search.h"

namespace planish {
namespace {

// How far points, of which there must be some, lie at most from the line through two of them that
// are far apart. `Points` has size() and places by index.
template <class Points>
double distance_from_line(const Points& points) {
  const auto farthest_from = [&](const glm::dvec3& place) {
    glm::dvec3 farthest = place;
    double most = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const glm::dvec3 point = points[i];
      const glm::dvec3 off = point - place;
      if (glm::dot(off, off) <= most) continue;
      most = glm::dot(off, off);
      farthest = point;
    }
    return farthest;
  };
  const glm::dvec3 from = farthest_from(points[0]), along = farthest_from(from) - from;
  const double length = glm::length(along);
  if (!(length > 0)) return 0;
  double most = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    most = std::max(most, glm::length(glm::cross(along, points[i] - from)));
  return most / length;
}

constexpr double kDefaultTolerance = 1e-4;
// Noise in spacings, up to which one round of smoothing does, and above which two do not.
constexpr double kLightSpacings = 0.08, kHeavySpacings = 0.3;

// How often points are moved before they are meshed, unless that is asked for.
std::int32_t smooth_rounds_for(const Reconstruction& result) {
  const double spacings = result.noise / result.spacing;
  return spacings > kHeavySpacings ? 4 : spacings > kLightSpacings ? 2 : 1;
}

// Sets how often points are moved and how far they are kept from the mesh, as asked for, or as
// result.noise, -1 where it was not measured, wants it with result.spacing and result.diagonal.
// Warns "tolerance-below-noise".
void choose_by_noise(const ReconstructOptions& options, Reconstruction& result) {
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

// A tolerance of more spacings than 10^12 points of one surface have.
constexpr double kMostSpacings = 300;

// Warns of points that were removed for lying far from all others, and of those that stick out.
void tell_outliers(const Callbacks& callbacks, std::int64_t outliers, std::int64_t strays) {
  const auto tell = [&](std::int64_t count, std::string_view one, std::string_view many) {
    if (count == 0) return;
    callbacks.warn(
        {.code = "outliers-removed",
         .message = counted(count, "point") +
                    (count == 1 ? std::string(one) + " and was" : std::string(many) + " and were") +
                    " removed; --outliers off keeps them all",
         .count = count});
  };
  tell(outliers, " lies far from all others", " lie far from all others");
  tell(strays, " sticks out of the surface around it", " stick out of the surface around them");
}

// Warns of a tolerance that is hundreds of times the spacing.
// Such parts vanish without being points that are left out.
void warn_of_scale(const Reconstruction& result, const Callbacks& callbacks) {
  const double spacing = result.spacing / result.diagonal;
  if (!(result.tolerance > kMostSpacings * spacing)) return;
  callbacks.warn(
      {.code = "coarse-tolerance",
       .message = formatted(
           "points lie {} of the diagonal apart, and the mesh may be off by {} of it: smaller "
           "parts lose their shape, as those of a cloud do whose parts lie far from each other; "
           "--tolerance-mesh {} keeps them, or each in a file of its own",
           short_number(spacing), short_number(result.tolerance), short_number(spacing / 2))});
}

// Warns of what an open or broken mesh lacks: it is no silent success.
void warn_of_mesh(const Reconstruction& result, const ReconstructOptions& options) {
  const Callbacks& callbacks = options.callbacks;
  const MeshStatistics& facts = result.statistics;
  if (facts.boundary_loop_count > 0)
    callbacks.warn(
        {.code = "open-mesh",
         .message = formatted(
             "the mesh is open: {}{} left, genus {}; --fill-holes N closes loops of up to N edges",
             counted(facts.boundary_loop_count, "boundary loop"),
             facts.boundary_loop_count == 1 ? " is" : " are", facts.genus),
         .count = facts.boundary_loop_count});
  if (facts.component_count > 1)
    callbacks.warn(
        {.code = "several-components",
         .message = formatted("the mesh has {} components; --components largest keeps one",
                              facts.component_count),
         .count = facts.component_count});
  if (result.dropped_component_count > 0)
    callbacks.warn({.code = "components-dropped",
                    .message = counted(result.dropped_component_count, "smaller component") +
                               (result.dropped_component_count == 1 ? " was" : " were") +
                               " dropped; --components all keeps all",
                    .count = result.dropped_component_count});
  if (result.strayed_count > 0)
    callbacks.warn({.code = "points-left-out",
                    .message = formatted(
                        "{} of {}{} farther than the tolerance from the mesh", result.strayed_count,
                        counted(std::ssize(result.used_points), "point"),
                        result.strayed_count == 1 ? " fits into no triangle and lies"
                                                  : " fit into no triangle and lie"),
                    .count = result.strayed_count});
  if (options.target_vertices > 0 && facts.vertex_count > options.target_vertices)
    callbacks.warn(
        {.code = "target-not-reached",
         .message = formatted("{} are left of {} aimed at; a larger --tolerance-mesh allows fewer",
                              counted(facts.vertex_count, "vertex"), options.target_vertices),
         .count = facts.vertex_count});
}

// Based on: the first step of "Smooth Surface Reconstruction using Doo-Sabin Subdivision
// Surfaces": an approximating mesh within a tolerance of every point, vertices a subset of them.

constexpr std::int32_t kMostSmoothRounds = 100;
constexpr std::size_t kFewestPoints = 4;
// Of the diagonal: single precision rounds to a tenth of it.
constexpr double kLeastWidth = 1e-6;
// Degrees at a corner of a quad where even spacing is asked for: it halves what is folded, and
// pairs 68 % of the triangles instead of 82 %.
constexpr double kEvenLargestAngle = 130;
// Of many points so many are meshed at first, or this part where they are fewer; a target in
// vertices wants twice as many, and may be a part of the points, too.
constexpr std::int64_t kSamples = 100'000, kPointsOfSample = 5, kPointsOfTarget = 10;

std::int64_t samples_of(std::int64_t point_count, const ReconstructOptions& options) {
  return std::max(std::min(kSamples, point_count / kPointsOfSample), 2 * options.target_vertices);
}

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
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("smooth: {} rounds are asked for; 0 to {} work", rounds, kMostSmoothRounds));
}

// A mesh through points of the cloud, before its triangles are paired.
struct MeshedCloud {
  std::vector<glm::dvec3> positions;  // smoothed, if asked for
  std::vector<std::int32_t> points;   // of each position, indices of the cloud
  std::vector<Triangle> triangles;
};

// The cloud on its way through the steps.
struct Work {
  const PointCloud& cloud;
  const Mesher& mesher;
  const ReconstructOptions& options;
  Reconstruction result;
  Stopwatch watch;
};

void require_points(std::size_t count) {
  if (count < kFewestPoints)
    throw Error(ErrorCode::UnusableMesh,
                formatted("{}{} left after cleaning; a surface needs at least {}",
                          counted(static_cast<std::int64_t>(count), "point"),
                          count == 1 ? " is" : " are", kFewestPoints));
}

// Of points along a line a Delaunay triangulation is as good as endless, and no surface is in them.
template <class Points>
void require_width(const Points& points, const Reconstruction& result) {
  const double width = distance_from_line(points) / result.diagonal;
  const double least = std::max(result.tolerance, kLeastWidth);
  if (width > least) return;
  throw Error(
      ErrorCode::UnusableMesh,
      formatted("{} lie on a line, but for {} of its length, and span no surface{}",
                counted(std::ssize(points), "point"), short_number(least),
                least > kLeastWidth ? "; a smaller --tolerance-mesh keeps what is thinner" : ""));
}

SimplifyOptions simplify_options(const Work& work) {
  return {.tolerance = work.result.tolerance * work.result.diagonal,
          .target_vertices = work.options.target_vertices,
          .spacing = work.options.spacing,
          .least_angle = work.options.least_angle,
          .max_valence = work.options.max_valence,
          .callbacks = share_of(work.options.callbacks, kRepaired, kSimplified)};
}

// Whoever asks for it has every point moved.
double noise_of_edges(const Work& work) {
  return work.options.smooth_rounds ? 0 : work.result.noise;
}

std::vector<glm::dvec3> clean_points(Work& work) {
  const Callbacks& callbacks = work.options.callbacks;
  Reconstruction& result = work.result;
  CleanOptions clean_options = work.options.clean;
  clean_options.callbacks = share_of(callbacks, 0, kCleaned);
  CleanPoints cleaned = clean(work.cloud.points, clean_options);
  result.used_points = std::move(cleaned.kept);
  result.duplicate_count = cleaned.duplicate_count;
  result.outlier_count = cleaned.outlier_count + cleaned.stray_count;
  result.spacing = cleaned.spacing;
  require_points(result.used_points.size());
  tell_outliers(callbacks, cleaned.outlier_count, cleaned.stray_count);
  std::vector<glm::dvec3> points = chosen(work.cloud.points, result.used_points);
  result.diagonal = diagonal_of(points);
  if (work.options.measure_noise) result.noise = measure_noise(points);
  choose_by_noise(work.options, result);
  require_width(points, result);
  warn_of_scale(result, work.options.callbacks);
  result.timing.clean = work.watch.lap();
  return points;
}

std::vector<Triangle> repaired(Work& work, std::span<const glm::dvec3> points,
                               std::vector<Triangle> triangles) {
  const ReconstructOptions& options = work.options;
  RepairedTriangles repaired =
      repair_triangles(points, std::move(triangles),
                       {.longest_filled_loop = options.longest_filled_loop,
                        .components = options.components,
                        .callbacks = share_of(options.callbacks, kMeshed, kRepaired)});
  work.result.filled_loop_count = repaired.filled_loop_count;
  work.result.dropped_component_count = repaired.dropped_component_count;
  if (!work.cloud.normals.empty())
    work.result.turned_component_count = turn_by_normals(
        points, chosen(work.cloud.normals, work.result.used_points), repaired.triangles);
  if (repaired.triangles.empty())
    throw Error(ErrorCode::UnusableMesh,
                "no surface was found in " + counted(std::ssize(points), "point"));
  work.result.timing.repair = work.watch.lap();
  return std::move(repaired.triangles);
}

// Different indices below `count`, in order.
std::vector<std::int32_t> ascending(std::span<const std::int32_t> indices, std::size_t count) {
  std::vector<bool> is_there(count, false);
  for (const std::int32_t index : indices) is_there[index] = true;
  std::vector<std::int32_t> sorted;
  sorted.reserve(indices.size());
  for (std::size_t i = 0; i < count; ++i)
    if (is_there[i]) sorted.push_back(static_cast<std::int32_t>(i));
  return sorted;
}

// Of the points that triangles name.
MeshedCloud vertices_of(const OrderedPoints& points, std::vector<Triangle> triangles) {
  std::vector<std::int32_t> vertex(points.size(), -1);
  for (const Triangle& t : triangles)
    for (const std::int32_t corner : t) vertex[corner] = 0;
  MeshedCloud meshed;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (vertex[i] < 0) continue;
    vertex[i] = static_cast<std::int32_t>(meshed.points.size());
    meshed.points.push_back(points.given(i));
    meshed.positions.push_back(points[i]);
  }
  for (Triangle& t : triangles)
    for (std::int32_t& corner : t) corner = vertex[corner];
  meshed.triangles = std::move(triangles);
  return meshed;
}

// `points`: of the cloud, that triangles name.
void keep_scan(Work& work, std::span<const std::int32_t> points,
               std::span<const Triangle> triangles) {
  if (!work.options.keeps_scan) return;
  PolygonMesh scan = polygons_of(triangles);
  scan.positions = chosen(work.cloud.points, points);
  for (glm::dvec3& position : scan.positions) position += work.cloud.origin;
  work.result.scan = without_unused_vertices(scan).mesh;
}

// The way of few points: all of them are meshed.
MeshedCloud mesh_all_points(Work& work) {
  const Callbacks& callbacks = work.options.callbacks;
  Reconstruction& result = work.result;
  std::vector<glm::dvec3> points = clean_points(work);
  if (result.smooth_rounds > 0)
    points = smooth_points(points, result.smooth_rounds, noise_of_edges(work),
                           share_of(callbacks, kCleaned, kSmoothed));
  result.timing.smooth = work.watch.lap();
  std::vector<Triangle> triangles = work.mesher(points, share_of(callbacks, kSmoothed, kMeshed));
  result.timing.mesh = work.watch.lap();
  triangles = repaired(work, points, std::move(triangles));
  keep_scan(work, result.used_points, triangles);
  if (result.tolerance > 0) {
    SimplifiedMesh simplified = simplify(points, triangles, simplify_options(work));
    triangles = std::move(simplified.triangles);
    result.strayed_count = simplified.strayed_count;
  }
  result.timing.simplify = work.watch.lap();
  result.distances = measure_distances(points, points, triangles);
  return {std::move(points), result.used_points, std::move(triangles)};
}

// The way of many points: few are meshed, and all others say where more are needed.
MeshedCloud mesh_coarse_first(Work& work) {
  const ReconstructOptions& options = work.options;
  const Callbacks& callbacks = options.callbacks;
  Reconstruction& result = work.result;
  OrderedPoints points(work.cloud.points);
  result.duplicate_count = drop_duplicates(points);
  require_points(points.size());
  CleanOptions clean_options = options.clean;
  clean_options.callbacks = share_of(callbacks, 0, kCleaned);
  std::optional<PointCritic> critic(std::in_place, points, clean_options);
  require_points(points.size());
  result.spacing = critic->spacing();
  result.diagonal = diagonal_of(points);
  if (options.measure_noise) result.noise = critic->noise();
  choose_by_noise(options, result);
  require_width(points, result);
  warn_of_scale(result, work.options.callbacks);
  std::int64_t stray_count = 0;
  const std::int64_t outlier_count = critic->outlier_count();
  const CleanOptions no_cleaning{.outliers = OutlierRule::Off};
  if (result.smooth_rounds > 0) critic->remove_all_strays();
  result.timing.clean = work.watch.lap();
  if (result.smooth_rounds > 0) {
    stray_count = critic->stray_count();
    critic.reset();
    smooth_points(points, result.smooth_rounds, noise_of_edges(work),
                  share_of(callbacks, kCleaned, kSmoothed));
    critic.emplace(points, no_cleaning);
  }
  result.timing.smooth = work.watch.lap();
  CoarseMesh coarse =
      mesh_coarse_first(points, *critic, work.mesher,
                        {.tolerance = result.tolerance * result.diagonal,
                         .least_samples = samples_of(std::ssize(points), options),
                         .repair = {.longest_filled_loop = options.longest_filled_loop,
                                    .components = options.components},
                         .normals = work.cloud.normals,
                         .callbacks = share_of(callbacks, kSmoothed, kRepaired)});
  stray_count += critic->stray_count();
  critic.reset();
  result.outlier_count = outlier_count + stray_count;
  tell_outliers(callbacks, outlier_count, stray_count);
  result.strayed_count = coarse.strayed_count;
  result.filled_loop_count = coarse.filled_loop_count;
  result.dropped_component_count = coarse.dropped_component_count;
  result.turned_component_count = coarse.turned_component_count;
  result.sample_count = coarse.sample_count;
  result.inserted_count = coarse.inserted_count;
  result.meshing_count = coarse.meshing_count;
  result.used_points = ascending(points.given(), work.cloud.points.size());
  result.timing.mesh = work.watch.lap();
  if (options.keeps_scan)
    keep_scan(work, chosen(points.given(), coarse.mesh.vertex_points), coarse.mesh.triangles);
  SimplifiedMesh simplified = simplify(points, std::move(coarse.mesh), simplify_options(work));
  result.timing.simplify = work.watch.lap();
  result.distances = measure_distances(points, simplified.triangles);
  const auto farthest =
      std::ranges::lower_bound(result.used_points, points.given(result.distances.farthest));
  result.distances.farthest = farthest - result.used_points.begin();
  return vertices_of(points, std::move(simplified.triangles));
}

// Pairs triangles, drops unused points, moves the mesh to where the file has it and notes the
// points it came from.
void finish_mesh(MeshedCloud meshed, Work& work) {
  Reconstruction& result = work.result;
  PolygonMesh polygons;
  if (work.options.pair_quads) {
    const bool even = work.options.spacing == Spacing::Even;
    polygons =
        pair_triangles(meshed.positions, meshed.triangles,
                       even ? PairOptions{.largest_angle = kEvenLargestAngle} : PairOptions{});
  } else {
    polygons = polygons_of(meshed.triangles);
    polygons.positions = std::move(meshed.positions);
  }
  UsedMesh used = without_unused_vertices(polygons);
  result.mesh = std::move(used.mesh);
  for (glm::dvec3& position : result.mesh.positions) position += work.cloud.origin;
  result.vertex_points = chosen(meshed.points, used.vertices);
  if (!work.cloud.colors.empty())
    result.mesh.colors = chosen(work.cloud.colors, result.vertex_points);
  result.mesh.attributes = attributes_of(work.cloud.attributes, result.vertex_points);
  require_usable(result.mesh, "reconstructed mesh");
  result.statistics = statistics(result.mesh);
  result.timing.measure = work.watch.lap();
}

}  // namespace

std::int64_t meshed_at_first(std::int64_t point_count, const ReconstructOptions& options) {
  const bool few = point_count >= options.coarse_from && options.tolerance.value_or(1) > 0 &&
                   options.target_vertices <= point_count / kPointsOfTarget;
  return few ? samples_of(point_count, options) : point_count;
}

Reconstruction reconstruct(const PointCloud& cloud, const Mesher& mesher,
                           const ReconstructOptions& options) {
#ifdef __EMSCRIPTEN__
  // There are no processes, so that nobody has a mesher, and what follows need not be carried.
  throw Error(ErrorCode::NoDevice, "points are not meshed in WebAssembly");
#endif
  check_options(options);
  const HostScope host(options.callbacks);
  Work work{.cloud = cloud, .mesher = mesher, .options = options};
  const std::int64_t count = std::ssize(cloud.points);
  MeshedCloud meshed =
      meshed_at_first(count, options) < count ? mesh_coarse_first(work) : mesh_all_points(work);
  options.callbacks.report("pair", kSimplified);
  finish_mesh(std::move(meshed), work);
  options.callbacks.report("pair", 1);
  warn_of_mesh(work.result, options);
  return std::move(work.result);
}

}  // namespace planish
