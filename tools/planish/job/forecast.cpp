#include "job/forecast.h"

#include <algorithm>
#include <span>
#include <thread>

#include "job/expected_triangles.h"
#include "job/job_input.h"
#include "job/least_step_faces.h"
#include "job/output_bytes.h"
#include "page/page.h"
#include "page/page_still.h"
#include "planish/core/error.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/surface/memory_need.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

struct MeshCounts {
  LevelCounts base;
  std::int64_t corners;
};

MeshCounts mesh_counts_of(const PreparedMesh& mesh) {
  const MeshTopology& topology = *mesh.topology;
  return {{topology.vertex_count(), topology.edge_count(), topology.face_count()},
          topology.corner_count()};
}

// Elements of the levels 0 to `last`: quads from level 1 on, triangles with Loop.
std::vector<LevelCounts> levels_to(const MeshCounts& mesh, Scheme scheme, int last) {
  std::vector<LevelCounts> levels{mesh.base};
  std::int64_t corners = mesh.corners;
  for (int level = 1; level <= last; ++level) {
    const LevelCounts& c = levels.back();
    const bool loop = scheme == Scheme::Loop;
    const LevelCounts next =
        loop ? LevelCounts{c.vertices + c.edges, 2 * c.edges + corners, 4 * c.faces}
             : LevelCounts{c.vertices + c.edges + c.faces, 2 * c.edges + corners, corners};
    corners = (loop ? 3 : 4) * next.faces;
    levels.push_back(next);
  }
  return levels;
}

// CPU seconds, reading and writing included, measured on two cores: of a million vertices of the
// mesh for each fit, of points of a surface, of vertices of a page's, of triangles cut where it
// bends, and of points that are meshed.
constexpr double kVertexSeconds = 6, kPointSeconds = 0.6, kPageSeconds = 4, kBendSeconds = 2.5,
                 kCloudSeconds = 80;

// Bytes of host memory, upper values of what the command took: tools/planish/README.md has them.
constexpr std::uint64_t kPageVertexBytes = 210 + 36, kBendBytes = 48, kBendUvBytes = 96;
constexpr std::uint64_t kTileVertexBytes = 180;
// Of a page's still picture: four samples of 8 bytes and a pixel of 4.
constexpr std::uint64_t kStillBytes = std::uint64_t{36} * kStillWidth * kStillHeight;
constexpr std::uint64_t kCloudFixedBytes = 40u << 20, kCloudPointBytes = 2400;

// Of B-spline faces, by quads of level 1 of a mesh of triangles, which has most points where none
// is regular: what they take, and for how many points of a surface they take the time.
constexpr std::uint64_t kStepCornerBytes = 6000;
constexpr double kStepPoints = 60;

// What packing takes beside the surface: a small one's plain bytes and those of the result; of a
// large one, quantized ones, and a block for each thread.
std::uint64_t packing_bytes(const LevelCounts& level) {
  const auto vertices = static_cast<std::uint64_t>(level.vertices);
  const auto faces = static_cast<std::uint64_t>(level.faces);
  if (level.faces <= kPackedFaces) return 48 * (vertices + faces);
  constexpr std::uint64_t kBlockBytes = 100'000'000;
  return 20 * vertices + 24 * faces +
         kBlockBytes * std::max(1u, std::thread::hardware_concurrency());
}

// The mesh and what its fits take, by corners of the mesh before triangles are joined: where the
// progressive method is named, where another or both may be made, and both of quads and triangles.
constexpr std::uint64_t kStartBytes = 20 << 20, kProgressiveBytes = 150, kFairBytes = 210,
                        kPrimalBytes = 300, kBothBytes = 290;

std::uint64_t solve_bytes(std::int64_t corners, bool makes_both, const Settings& settings) {
  const std::uint64_t bytes = settings.scheme != Scheme::DooSabin ? kPrimalBytes
                              : makes_both                        ? kBothBytes
                              : settings.interpolation == InterpolationChoice::Progressive
                                  ? kProgressiveBytes
                                  : kFairBytes;
  return kStartBytes + bytes * static_cast<std::uint64_t>(corners);
}

// What a job holds at its peak. Doo-Sabin surfaces go by blocks to who writes them, but for those
// who need neighbours: values of vertices.
std::uint64_t held_bytes(const RefinedAttributes& attributes,
                         const std::vector<LevelCounts>& levels, std::uint64_t solve,
                         const Settings& settings) {
  const LastLevel last = settings.scheme != Scheme::DooSabin ? LastLevel::Full
                         : settings.attributes.any()         ? LastLevel::None
                                                             : LastLevel::Blocks;
  std::uint64_t surface = tessellation_bytes(levels, last, attributes);
  // Fields, and what they are made from: who is a vertex's neighbour.
  constexpr std::uint64_t kFieldBytes = 120;
  if (settings.attributes.any())
    surface += kFieldBytes * static_cast<std::uint64_t>(levels.back().vertices);
  if (settings.compression != GltfCompression::None) surface += packing_bytes(levels.back());
  return std::max(solve, surface + solve / 4);
}

int highest_level(const std::vector<PlannedOutput>& outputs) {
  int level = 1;  // where the surface is measured
  for (const PlannedOutput& output : outputs) {
    // Tiles are made one by one, and STEP has no levels.
    if (output.kind == OutputKind::Surface && info_of(output.format).has_fineness())
      level = std::max(level, output.fineness.level);
  }
  return level;
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

// What any job with these numbers of elements takes; those of files aside that curvature decides.
Forecast forecast_by_counts(const MeshCounts& counts, const RefinedAttributes& attributes,
                            std::uint64_t solve, const Settings& settings,
                            const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes) {
  int finest = kPageLevel;
  for (const PlannedOutput& output : outputs) finest = std::max(finest, output.fineness.level);
  const std::vector<LevelCounts> levels = levels_to(counts, settings.scheme, finest);
  const std::span<const LevelCounts> all(levels);
  Forecast forecast;
  double points = 0;
  std::uint64_t beside = 0;  // the held surface
  for (const PlannedOutput& output : outputs) {
    OutputForecast& file = forecast.outputs.emplace_back();
    if (output.fineness.is_adaptive()) continue;
    if (info_of(output.format).is_brep) {
      points += kStepPoints * static_cast<double>(counts.corners);
      beside = std::max(beside, kStepCornerBytes * static_cast<std::uint64_t>(counts.corners));
      continue;
    }
    const int level = level_of(output, settings);
    const bool is_tiles = info_of(output.format).is_tiles;
    for (const LevelCounts& l : all.subspan(is_tiles ? 1 : level, is_tiles ? level : 1)) {
      file.vertices += l.vertices;
      file.faces += l.faces;
    }
    points += static_cast<double>(file.vertices);
    if (is_tiles)
      beside = std::max(beside, kTileVertexBytes * static_cast<std::uint64_t>(std::min(
                                                       settings.tile_vertices, file.vertices)));
  }
  double seconds = kPointSeconds * points;
  if (page_bytes > 0) {
    const std::int64_t vertices = page_counts(levels, page_bytes).vertices;
    beside += kStillBytes + kPageVertexBytes * static_cast<std::uint64_t>(vertices);
    seconds += kPageSeconds * static_cast<double>(vertices);
  }
  const double fits = chooses_by_measurement(settings, outputs) ? 2 : 1;
  seconds += kVertexSeconds * fits * static_cast<double>(levels[0].vertices);
  forecast.peak_bytes =
      beside + held_bytes(attributes, levels_to(counts, settings.scheme, highest_level(outputs)),
                          solve, settings);
  forecast.seconds = 1e-6 * seconds;
  return forecast;
}

std::uint64_t solve_bytes(const ReadyFit& ready, const Settings& settings) {
  const bool makes_both = ready.paired && !ready.is_plainly_halved;
  return solve_bytes(ready.fitted.options.prepared->topology->corner_count(), makes_both, settings);
}

double thread_count() { return std::max(1u, std::thread::hardware_concurrency()); }

}  // namespace

const ReadyFit& expected_fit(const ReadyFit& ready) {
  return ready.paired && ready.is_plainly_halved ? *ready.paired : ready;
}

Forecast forecast_of(const ReadyFit& ready, const Settings& settings,
                     const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes) {
  const FittedMesh& expected = expected_fit(ready).fitted;
  const PolygonMesh& mesh = expected.mesh;
  const PreparedMesh& prepared = *expected.options.prepared;
  const auto attributes = RefinedAttributes::of(mesh);
  Forecast forecast =
      forecast_by_counts(mesh_counts_of(prepared), attributes, solve_bytes(ready, settings),
                         settings, outputs, page_bytes);
  WrittenShape shape = written_shape(mesh, prepared);
  shape.property_count = static_cast<std::size_t>(attributes.numbers);
  const bool triangles = settings.scheme == Scheme::Loop;
  double most = 0, bends = 0;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    OutputForecast& file = forecast.outputs[i];
    if (outputs[i].fineness.is_adaptive()) {
      const double count = expected_triangles(mesh, prepared, outputs[i].fineness);
      bends += count;
      most = std::max(most, count);
    } else if (info_of(outputs[i].format).is_brep) {
      file.faces = least_step_faces(mesh, *prepared.topology, settings.step.faces.face_size);
    } else if (info_of(outputs[i].format).has_fineness()) {
      const WrittenLevel written{
          level_of(outputs[i], settings), {file.vertices, 0, file.faces}, triangles};
      file.bytes = output_bytes(shape, written, outputs[i], settings);
      file.vertices = written_vertices(shape, written, outputs[i].kind);
    }
  }
  const std::uint64_t triangle_bytes = attributes.uvs ? kBendUvBytes : kBendBytes;
  forecast.peak_bytes += triangle_bytes * static_cast<std::uint64_t>(most);
  forecast.seconds = (forecast.seconds + 1e-6 * kBendSeconds * bends) / thread_count();
  return forecast;
}

Forecast forecast_of_points(std::int64_t point_count, const Settings& settings,
                            const std::vector<PlannedOutput>& outputs, std::uint64_t page_bytes) {
  // A closed mesh of triangles has twice as many faces as vertices; pairs of them are quads.
  const MeshCounts counts{{point_count, 3 * point_count, 2 * point_count}, 6 * point_count};
  Forecast forecast = forecast_by_counts(counts, {}, solve_bytes(counts.corners, false, settings),
                                         settings, outputs, page_bytes);
  forecast.outputs.assign(outputs.size(), {});
  const std::uint64_t meshing =
      kCloudFixedBytes + kCloudPointBytes * static_cast<std::uint64_t>(point_count);
  forecast.peak_bytes = std::max(forecast.peak_bytes, meshing);
  for (const PlannedOutput& output : outputs)
    if (output.fineness.is_adaptive()) forecast.peak_bytes = 0;
  forecast.seconds =
      forecast.seconds / thread_count() + 1e-6 * kCloudSeconds * static_cast<double>(point_count);
  return forecast;
}

void require_memory_for(const ReadyFit& ready, const Settings& settings,
                        const std::vector<PlannedOutput>& outputs) {
  const int wanted = highest_level(outputs);
  const FittedMesh& expected = expected_fit(ready).fitted;
  const MeshCounts counts = mesh_counts_of(*expected.options.prepared);
  const std::uint64_t free = available_memory_bytes();
  require_indices(levels_to(counts, settings.scheme, wanted));
  const auto need = [&](int level) {
    const std::vector<LevelCounts> levels = levels_to(counts, settings.scheme, level);
    return held_bytes(RefinedAttributes::of(expected.mesh), levels, solve_bytes(ready, settings),
                      settings);
  };
  const std::uint64_t needed = need(wanted);
  if (needed <= free) return;
  int fitting = wanted - 1;
  while (fitting >= 0 && need(fitting) > free) --fitting;
  throw Error(ErrorCode::OutOfMemory,
              "level " + std::to_string(wanted) + " needs about " + byte_size(needed) +
                  " of memory where " + byte_size(free) + " are free; " +
                  (fitting < 0 ? "no level fits"
                               : "--levels " + std::to_string(fitting) + " fits (" +
                                     byte_size(need(fitting)) + ")"));
}

}  // namespace planish::command
