#include "planish/job/forecast.h"
#include "planish/core/counted.h"
#include "planish/core/number_text.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <thread>

#include "planish/core/error.h"
#include "planish/job/expected_triangles.h"
#include "planish/job/held_bytes.h"
#include "planish/job/job_input.h"
#include "planish/job/least_step_faces.h"
#include "planish/job/output_bytes.h"
#include "planish/job/page/page.h"
#include "planish/job/text.h"
#include "planish/pipeline/bake_maps.h"
#include "planish/pipeline/choose_fit.h"
#include "planish/reconstruct/mesher_process.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

MeshCounts mesh_counts_of(const PreparedMesh& mesh) {
  const MeshTopology& topology = *mesh.topology;
  return {{topology.vertex_count(), topology.edge_count(), topology.face_count()},
          topology.corner_count()};
}

// CPU seconds, reading and writing included, measured on two cores: of a million vertices of the
// mesh for each fit, of points of a surface, of vertices of a page's, of triangles cut where it
// bends, of points that are meshed, and of those of a large cloud of which few are.
constexpr double kVertexSeconds = 6, kPointSeconds = 0.6, kPageSeconds = 4, kBendSeconds = 2.5,
                 kCloudSeconds = 80, kCarriedSeconds = 20;
// The same of a vertex that may be left: two to ten further fits, each measured; with other schemes
// than Doo-Sabin, whose levels are made whole for that.
constexpr double kLeavingSeconds = 25, kLeavingPrimalSeconds = 120;

// And of places of a baked map, of which it has so many along a side at least; its PNG included.
constexpr double kBakeSeconds = 0.2;
constexpr int kBakeSide = 4096;

// Bytes of host memory, upper values of what the command took: tools/planish/README.md has them.
constexpr std::uint64_t kPageVertexBytes = 210 + 36, kPageUvBytes = 110, kBendBytes = 48,
                        kBendUvBytes = 96;
constexpr std::uint64_t kTileVertexBytes = 180;
// Of a page's still picture: four samples of 8 bytes and a pixel of 4.
constexpr std::uint64_t kStillBytes = std::uint64_t{36} * kStillWidth * kStillHeight;
constexpr std::uint64_t kCloudFixedBytes = 40u << 20, kCarriedPointBytes = 130;
// Copies of what points have besides their places: the reader's and the cloud's.
constexpr std::uint64_t kRiderCopies = 2;
// So many times the vertices and faces a mesh may have where vertices are added to it: of 60 meshes
// 2.5 to 7 times.
// With added vertices a mesh has about 3 times its faces, seldom more than so many.
constexpr std::int64_t kMostAdded = 4;
// Samples may be so many times more than asked for.
constexpr double kMostSamples = 1.3;

// Of B-spline faces, by quads of level 1 of a mesh of triangles, which has most points where none
// is regular: what they take, and for how many points of a surface they take the time; of degree 2
// and 3.
constexpr std::uint64_t kStepCornerBytes = 6000, kCubicCornerBytes = 9000;
constexpr double kStepPoints = 60, kCubicPoints = 150;

// The mesh and what its fits take, by corners of the mesh before triangles are joined: where the
// progressive method is named, where another or both may be made, and both of quads and triangles.
constexpr std::uint64_t kProgressiveBytes = 150, kFairBytes = 210, kPrimalBytes = 300,
                        kBothBytes = 290;

// Where vertices may be left, the best surface so far beside the next one and how it bends.
constexpr std::uint64_t kLeavingBytes = 110, kLeavingPrimalBytes = 800;

bool may_leave_vertices(const Settings& settings) {
  return settings.within.is_measured || settings.within.of_diagonal.value_or(0) > 0;
}

std::uint64_t solve_bytes(std::int64_t corners, bool makes_both, const Settings& settings) {
  const bool is_primal = settings.scheme != Scheme::DooSabin;
  std::uint64_t bytes = is_primal    ? kPrimalBytes
                        : makes_both ? kBothBytes
                        : settings.interpolation == InterpolationChoice::Progressive
                            ? kProgressiveBytes
                            : kFairBytes;
  if (may_leave_vertices(settings)) bytes += is_primal ? kLeavingPrimalBytes : kLeavingBytes;
  return bytes * static_cast<std::uint64_t>(corners);
}

// Of control cages beside surfaces, which are of other fits where the method is left open.
int cage_fits(const Settings& settings, const std::vector<PlannedOutput>& outputs) {
  const auto is_cage = [](const PlannedOutput& output) { return output.kind == OutputKind::Cage; };
  return chooses_by_measurement(settings) && std::ranges::any_of(outputs, is_cage) ? 1 : 0;
}

// The levels that are held together: the highest, or those of detail in one file.
std::vector<int> held_levels(const std::vector<PlannedOutput>& outputs) {
  std::vector<int> held{1};  // where the surface is measured
  for (const PlannedOutput& output : outputs) {
    // Tiles are made one by one, and STEP has no levels.
    if (output.kind != OutputKind::Surface || !info_of(output.format).has_fineness()) continue;
    std::vector<int> levels;
    for (const Fineness& fineness : output.finenesses()) levels.push_back(fineness.level);
    held = std::max(held, levels);  // by the first, which is the highest
  }
  return held;
}

// Whose elements the file has. Control cages of the fair method are its meshes of level 1.
int level_of(const PlannedOutput& output, const Settings& settings) {
  if (output.kind == OutputKind::Surface) return output.fineness.level;
  return settings.interpolation == InterpolationChoice::Fair ? 1 : 0;
}

// The finest level that a page shows: the next is made while that of the last leaves room, which
// takes three bytes a vertex at least.
const LevelCounts& page_counts(const std::vector<LevelCounts>& levels, std::uint64_t page_bytes) {
  std::size_t level = 0;
  while (level < kPageLevel && 9 * levels[level].vertices / 2 <= std::int64_t(page_bytes)) ++level;
  return levels[level];
}

// What any job with these numbers of elements takes, of memory beside HeldBytes; of files those
// aside that curvature decides.
Forecast forecast_by_counts(const MeshCounts& counts, const Settings& settings,
                            const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes) {
  int finest = kPageLevel;
  for (const PlannedOutput& output : outputs) finest = std::max(finest, output.fineness.level);
  const std::vector<LevelCounts> levels = levels_to(counts, settings.scheme, finest);
  const std::span<const LevelCounts> all(levels);
  Forecast forecast;
  double points = 0;
  for (const PlannedOutput& output : outputs) {
    OutputForecast& file = forecast.outputs.emplace_back();
    if (output.fineness.is_adaptive()) continue;
    if (info_of(output.format).is_brep) {
      const bool is_cubic = settings.scheme == Scheme::CatmullClark;
      points += (is_cubic ? kCubicPoints : kStepPoints) * static_cast<double>(counts.corners);
      forecast.peak_bytes =
          std::max(forecast.peak_bytes, (is_cubic ? kCubicCornerBytes : kStepCornerBytes) *
                                            static_cast<std::uint64_t>(counts.corners));
      continue;
    }
    const int level = level_of(output, settings);
    const bool is_tiles = info_of(output.format).is_tiles;
    const auto add = [&](const LevelCounts& l) {
      file.vertices += l.vertices;
      file.faces += l.faces;
    };
    std::ranges::for_each(all.subspan(is_tiles ? 1 : level, is_tiles ? level : 1), add);
    for (const Fineness& coarser : output.coarser)
      if (!coarser.is_adaptive()) add(levels[coarser.level]);
    points += static_cast<double>(file.vertices);
    if (is_tiles)
      forecast.peak_bytes = std::max(
          forecast.peak_bytes, kTileVertexBytes * static_cast<std::uint64_t>(std::min(
                                                      settings.tile_vertices, file.vertices)));
  }
  double seconds = kPointSeconds * points;
  if (page_bytes > 0) {
    const std::int64_t vertices = page_counts(levels, page_bytes).vertices;
    forecast.peak_bytes += kStillBytes + kPageVertexBytes * static_cast<std::uint64_t>(vertices);
    seconds += kPageSeconds * static_cast<double>(vertices);
  }
  const double fits = (chooses_by_measurement(settings) ? 2 : 1) + cage_fits(settings, outputs);
  const double leaving = !may_leave_vertices(settings)         ? 0
                         : settings.scheme != Scheme::DooSabin ? kLeavingPrimalSeconds
                                                               : kLeavingSeconds;
  seconds += (kVertexSeconds * fits + leaving) * static_cast<double>(levels[0].vertices);
  forecast.seconds = 1e-6 * seconds;
  return forecast;
}

std::uint64_t solve_bytes(const ReadyFit& ready, const Settings& settings,
                          const std::vector<PlannedOutput>& outputs) {
  const bool makes_both = ready.paired && !ready.is_plainly_halved;
  const std::int64_t corners = ready.fitted.options.prepared->topology->corner_count();
  const std::uint64_t cages = kProgressiveBytes * cage_fits(settings, outputs);
  return solve_bytes(corners, makes_both, settings) + cages * static_cast<std::uint64_t>(corners);
}

std::uint64_t rider_bytes(const PointCloud& cloud) {
  std::uint64_t bytes =
      std::span(cloud.normals).size_bytes() + std::span(cloud.colors).size_bytes();
  for (const VertexAttribute& attribute : cloud.attributes)
    bytes += std::span(attribute.values).size_bytes();
  return bytes;
}

double thread_count() { return std::max(1u, std::thread::hardware_concurrency()); }

const FittedMesh& expected_mesh(const MeshNeed& mesh) { return expected_fit(*mesh.ready).fitted; }

// Whose level is settled: as if vertices were added where they may be.
MeshDensity expected_density(const MeshNeed& mesh) {
  MeshDensity density = expected_mesh(mesh).density;
  density.is_refined |= may_refine(*mesh.ready);
  return density;
}

MeshCounts expected_counts(const MeshNeed& mesh) {
  MeshCounts counts = mesh_counts_of(*expected_mesh(mesh).options.prepared);
  if (mesh.ready->refined || !may_refine(*mesh.ready)) return counts;
  for (std::int64_t* count :
       {&counts.base.vertices, &counts.base.edges, &counts.base.faces, &counts.corners})
    *count *= kMostAdded;
  return counts;
}

std::vector<PlannedOutput> settled_for(const MeshNeed& mesh,
                                       const std::vector<PlannedOutput>& outputs) {
  return settled(outputs, expected_density(mesh).level());
}

// With so many levels less, as far as there are any.
std::uint64_t held_bytes(std::span<const MeshNeed> meshes, const Settings& settings,
                         const std::vector<PlannedOutput>& outputs, int less = 0) {
  // Else a level is measured, and nothing rides on it.
  const bool writes_levels = std::ranges::any_of(outputs, [](const PlannedOutput& output) {
    return output.kind == OutputKind::Surface && info_of(output.format).has_fineness() &&
           !output.fineness.is_adaptive();
  });
  HeldBytes held(settings);
  for (const MeshNeed& mesh : meshes) {
    const FittedMesh& expected = expected_mesh(mesh);
    std::vector<int> levels = held_levels(settled_for(mesh, outputs));
    for (int& level : levels) level = std::max(0, level - less);
    held.add(RefinedAttributes::of(expected.mesh), expected_counts(mesh), levels,
             solve_bytes(*mesh.ready, settings, outputs), mesh.vertices, writes_levels);
  }
  return held.peak();
}

// Maps of a mesh, whose size in a file nobody knows.
void add_bake(const PolygonMesh& mesh, const Settings& settings,
              const std::vector<PlannedOutput>& outputs, Forecast& forecast) {
  const int level = bake_level(mesh, settings.bake);
  const auto faces = static_cast<std::int64_t>(
      std::ldexp(static_cast<double>(mesh.face_vertices.size()), 2 * (level - 1)));
  forecast.making_bytes += bake_bytes(mesh.face_count() + faces, settings.bake);
  const double side = std::max(settings.bake, kBakeSide);
  const auto maps = static_cast<double>(std::max<std::size_t>(mesh.groups.size(), 1));
  forecast.seconds +=
      1e-6 * (kBakeSeconds * side * side * maps + kPointSeconds * static_cast<double>(faces));
  for (std::size_t i = 0; i < outputs.size(); ++i)
    if (outputs[i].kind == OutputKind::Surface) forecast.outputs[i].bytes.reset();
}

// One mesh's, its memory beside HeldBytes.
Forecast forecast_of_mesh(const MeshNeed& need, const Settings& settings,
                          const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes) {
  const FittedMesh& expected = expected_mesh(need);
  const PolygonMesh& mesh = expected.mesh;
  const PreparedMesh& prepared = *expected.options.prepared;
  const auto attributes = RefinedAttributes::of(mesh);
  Forecast forecast = forecast_by_counts(mesh_counts_of(prepared), settings, outputs, page_bytes);
  WrittenShape shape = written_shape(mesh, prepared);
  shape.property_count = static_cast<std::size_t>(attributes.numbers);
  const bool triangles = settings.scheme == Scheme::Loop;
  double most = 0, bends = 0;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    OutputForecast& file = forecast.outputs[i];
    const PlannedOutput& output = outputs[i];
    if (output.fineness.is_adaptive()) {
      double count = 0;
      for (const Fineness& fineness : output.finenesses())
        count += expected_triangles(mesh, prepared, fineness);
      bends += count;
      most = std::max(most, count);
    } else if (info_of(output.format).is_brep) {
      file.faces = least_step_faces(mesh, *prepared.topology, settings.step.faces.face_size);
    } else if (info_of(output.format).has_fineness()) {
      const std::vector<LevelCounts> levels = levels_to(mesh_counts_of(prepared), settings.scheme,
                                                        std::max(level_of(output, settings), 1));
      file.vertices = 0;
      for (const Fineness& fineness : output.finenesses()) {
        const int level = output.coarser.empty() ? level_of(output, settings) : fineness.level;
        const WrittenLevel written{level, levels[level], triangles};
        const auto bytes = output_bytes(shape, written, output, settings);
        const std::int64_t vertices = written_vertices(shape, written, output.kind);
        if (bytes)
          file.bytes = file.bytes.value_or(0) + *bytes +
                       (need.vertices == nullptr ? 0
                                                 : static_cast<std::uint64_t>(vertices) *
                                                       need.vertices->bytes_of_vertex());
        file.vertices += vertices;
      }
    }
  }
  const std::uint64_t triangle_bytes = attributes.uvs ? kBendUvBytes : kBendBytes;
  forecast.peak_bytes += triangle_bytes * static_cast<std::uint64_t>(most);
  if (need.vertices != nullptr && most > 0) {
    // Half as many rows as triangles.
    const RideBytes rides =
        ride_bytes(*need.vertices, settings, static_cast<std::uint64_t>(most / 2), 0, true);
    forecast.peak_bytes += rides.rows;
    forecast.making_bytes = rides.making;
  }
  forecast.seconds += 1e-6 * kBendSeconds * bends;
  if (page_bytes > 0 && attributes.uvs) {
    const auto levels = levels_to(mesh_counts_of(prepared), settings.scheme, kPageLevel);
    forecast.peak_bytes +=
        kPageUvBytes * static_cast<std::uint64_t>(page_counts(levels, page_bytes).vertices);
  }
  if (settings.bake > 0) add_bake(mesh, settings, outputs, forecast);
  return forecast;
}

}  // namespace

const ReadyFit& expected_fit(const ReadyFit& ready) {
  if (ready.refined) return *ready.refined;
  return ready.paired && ready.is_plainly_halved ? *ready.paired : ready;
}

Forecast forecast_of(std::span<const MeshNeed> meshes, const Settings& settings,
                     const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes,
                     std::uint64_t asset_bytes) {
  Forecast all;
  all.outputs.resize(outputs.size());
  all.peak_bytes = asset_bytes + held_bytes(meshes, settings, outputs);
  for (const MeshNeed& mesh : meshes) {
    const Forecast one = forecast_of_mesh(mesh, settings, settled_for(mesh, outputs), page_bytes);
    all.peak_bytes += one.peak_bytes;
    all.making_bytes = std::max(all.making_bytes, one.making_bytes);
    all.seconds += one.seconds / thread_count();
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      OutputForecast& file = all.outputs[i];
      file.vertices += one.outputs[i].vertices;
      file.faces += one.outputs[i].faces;
      if (one.outputs[i].bytes) file.bytes = file.bytes.value_or(0) + *one.outputs[i].bytes;
    }
  }
  all.peak_bytes += all.making_bytes;
  // What is no mesh is at most the file again.
  for (OutputForecast& file : all.outputs)
    if (file.bytes) *file.bytes += asset_bytes;
  return all;
}

Forecast forecast_of_points(const PointCloud& cloud, const Settings& settings,
                            const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes) {
  const std::int64_t point_count = std::ssize(cloud.points);
  const std::int64_t first = meshed_at_first(point_count, settings.points);
  const bool few = first < point_count;
  const auto meshed = static_cast<std::int64_t>(few ? kMostSamples * static_cast<double>(first)
                                                    : static_cast<double>(first));
  // A closed mesh of triangles has twice as many faces as vertices; pairs of them are quads.
  const MeshCounts counts{{meshed, 3 * meshed, 2 * meshed}, 6 * meshed};
  Forecast forecast = forecast_by_counts(counts, settings, outputs, page_bytes);
  HeldBytes held(settings);
  held.add({}, counts, held_levels(outputs), solve_bytes(counts.corners, false, settings));
  forecast.outputs.assign(outputs.size(), {});
  const auto carried = few ? static_cast<std::uint64_t>(point_count) : 0;
  const std::uint64_t meshing =
      kCloudFixedBytes + kMesherPointBytes * static_cast<std::uint64_t>(meshed);
  forecast.peak_bytes = std::max(forecast.peak_bytes + held.peak(), meshing) +
                        kCarriedPointBytes * carried + kRiderCopies * rider_bytes(cloud);
  for (const PlannedOutput& output : outputs)
    if (output.fineness.is_adaptive()) forecast.peak_bytes = 0;
  forecast.seconds =
      forecast.seconds / thread_count() + 1e-6 * (kCloudSeconds * static_cast<double>(meshed) +
                                                  kCarriedSeconds * static_cast<double>(carried));
  return forecast;
}

void require_memory_for(std::span<const MeshNeed> meshes, const Settings& settings,
                        const std::vector<PlannedOutput>& outputs) {
  int wanted = 0;
  for (const MeshNeed& mesh : meshes) {
    const int finest = held_levels(settled_for(mesh, outputs)).front();
    require_indices(
        levels_to(mesh_counts_of(*expected_mesh(mesh).options.prepared), settings.scheme, finest));
    wanted = std::max(wanted, finest);
  }
  const std::uint64_t free = available_memory_bytes();
  const auto need = [&](int level) {
    return held_bytes(meshes, settings, outputs, wanted - level);
  };
  const std::uint64_t needed = need(wanted);
  if (needed <= free) return;
  int fitting = wanted - 1;
  while (fitting >= 0 && need(fitting) > free) --fitting;
  const std::string of = meshes.size() == 1 ? "" : " of " + counted(std::ssize(meshes), "mesh");
  throw Error(ErrorCode::OutOfMemory,
              formatted("level {}{} needs about {} of memory where {} are free; {}", wanted, of,
                        byte_size(needed), byte_size(free),
                        fitting < 0 ? "no level fits"
                                    : formatted("--levels {} fits ({})", fitting,
                                                byte_size(need(fitting)))));
}

}  // namespace planish
