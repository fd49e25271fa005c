#include "job/forecast.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "job/job_input.h"
#include "job/output_bytes.h"
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

// Seconds a million points of one level take on one thread, reading and writing included, and a
// million vertices of the mesh (measured on a loaded machine of two cores: an upper value).
constexpr double kSecondsPerMillionPoints = 1.6;
constexpr double kSecondsPerMillionVertices = 8;

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

// What a job holds at its peak. Doo-Sabin surfaces go by blocks to who writes them, but for those
// who need neighbours: values of vertices.
std::uint64_t peak_bytes(const PolygonMesh& mesh, const std::vector<LevelCounts>& levels,
                         const Settings& settings) {
  // The mesh, its stencils and the solve's vectors take about this for a vertex.
  constexpr std::uint64_t kSolveBytes = 1200;
  const std::uint64_t solve = kSolveBytes * static_cast<std::uint64_t>(levels[0].vertices);
  const LastLevel last = settings.scheme != Scheme::DooSabin ? LastLevel::Full
                         : settings.attributes.any()         ? LastLevel::None
                                                             : LastLevel::Blocks;
  std::uint64_t surface = tessellation_bytes(levels, last, RefinedAttributes::of(mesh));
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
    // Tiles are made one by one.
    if (output.kind == OutputKind::Surface && !info_of(output.format).is_tiles)
      level = std::max(level, output.fineness.level);
  }
  return level;
}

}  // namespace

Forecast forecast_of(const PolygonMesh& mesh, const PreparedMesh& prepared,
                     const Settings& settings, const std::vector<PlannedOutput>& outputs) {
  const MeshCounts counts = mesh_counts_of(prepared);
  int highest = highest_level(outputs);
  const std::vector<LevelCounts> held = levels_to(counts, settings.scheme, highest);
  for (const PlannedOutput& output : outputs) highest = std::max(highest, output.fineness.level);
  const std::vector<LevelCounts> levels = levels_to(counts, settings.scheme, highest);
  const WrittenShape shape = written_shape(mesh, prepared);
  const bool triangles = settings.scheme == Scheme::Loop;
  Forecast forecast;
  double points = 0;
  for (const PlannedOutput& output : outputs) {
    const int level = output.kind == OutputKind::Surface ? output.fineness.level : 0;
    const auto bytes_of = [&](int l) {
      return output_bytes(shape, {l, levels[static_cast<std::size_t>(l)], triangles}, output,
                          settings);
    };
    std::uint64_t bytes = bytes_of(level);
    points += static_cast<double>(levels[static_cast<std::size_t>(level)].vertices);
    // Tiles have every level.
    for (int l = 1; info_of(output.format).is_tiles && l < level; ++l) {
      bytes += bytes_of(l);
      points += static_cast<double>(levels[static_cast<std::size_t>(l)].vertices);
    }
    forecast.output_bytes.push_back(bytes);
  }
  forecast.peak_bytes = peak_bytes(mesh, held, settings);
  const double threads = std::max(1u, std::thread::hardware_concurrency());
  const double fits = chooses_by_measurement(settings, outputs) ? 2 : 1;
  forecast.seconds = (kSecondsPerMillionPoints * points +
                      kSecondsPerMillionVertices * fits * static_cast<double>(levels[0].vertices)) *
                     1e-6 / threads;
  return forecast;
}

void require_memory_for(const PolygonMesh& mesh, const PreparedMesh& prepared,
                        const Settings& settings, const std::vector<PlannedOutput>& outputs) {
  const int wanted = highest_level(outputs);
  const MeshCounts counts = mesh_counts_of(prepared);
  const std::uint64_t free = available_memory_bytes();
  require_indices(levels_to(counts, settings.scheme, wanted));
  const auto need = [&](int level) {
    return peak_bytes(mesh, levels_to(counts, settings.scheme, level), settings);
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
