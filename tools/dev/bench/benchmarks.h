#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::bench {

/// Smallest odd count that the project's own requirements accept as a median.
inline constexpr int kRepetitions = 15;

struct Options {
  std::int32_t quad_count = 1'000'000;  ///< of the torus grid, rounded to a square
  int sphere_level = 6;                 ///< of the rough icosphere; 6 has 40,962 vertices
  int repetitions = kRepetitions;
  /// Given points of the groups `kernels` and `frame`.
  std::vector<std::int32_t> point_counts = {10'000, 100'000, 1'000'000};
  std::int32_t hub_faces = 10'000;  ///< around each hub of the group `kernels`
  int loop_frames = 240;
  std::uint64_t copy_bytes = 256u << 20;  ///< of each buffer of the copies; as far as it fits
  std::string device;                     ///< Vulkan's, as in vulkan::pick_device; empty: the best
  bool hardware_kernels = false;          ///< kernels as hardware gets them, whatever the device
  std::uint64_t max_range = 0;            ///< as ContextOptions::max_storage_range
  std::vector<std::string> groups;        ///< empty: all
  std::filesystem::path json;             ///< empty: none
};

/// One way to do a piece of work. `run` does it once.
struct Peer {
  std::string name;
  std::function<void()> run;
};

/// Ways to do the same work. Ratios are relative to the peer named `baseline`.
struct Group {
  std::string name;  ///< no spaces or slashes
  std::string size;  ///< what it ran on, for the reader
  std::string baseline;
  std::vector<Peer> peers;
};

struct Row {
  std::string group, size, peer;
  int repetitions = 0;
  double median_ms = 0, least_ms = 0;  ///< wall clock
  double cpu_ms = 0;                   ///< median CPU time of the process and of those it started
  double ratio = 0;                    ///< median relative to the baseline's
  /// What else was counted or measured, by the names that details.md and bench.schema.json explain.
  std::vector<std::pair<std::string, double>> figures;
  std::string refused;  ///< why there are no figures: what the device lacks, with its limit
};

/// Of times in milliseconds; 0 of none.
[[nodiscard]] double median(std::vector<double> values);
/// CPU time of all threads of this process and of the children that it has waited for.
[[nodiscard]] double process_cpu_ms();

/// A row of times that somebody else took.
[[nodiscard]] Row row_of_times(const Group& group, const std::string& peer,
                               const std::vector<double>& times_ms);

/// Takes Google Benchmark's flags out of a program's, before run_group(). Runs are interleaved.
void initialize_benchmark(int& argc, char** argv);

/// Runs every peer once to warm up, then `repetitions` times each in one process, in random order
/// (Google Benchmark's interleaving), so that what disturbs the machine disturbs all alike.
[[nodiscard]] std::vector<Row> run_group(const Group& group, int repetitions);

/// Float peers round weights and sums: some 1e-7 of the largest coordinate. Ten iterations and
/// two stopping rules at 1e-6 stay below this too.
inline constexpr double kAgreement = 1e-5;

/// Throws std::runtime_error naming `what` when the points differ by more than kAgreement of the
/// largest coordinate of `expected`: a benchmark that computes something else is worthless.
void require_agreement(std::string_view what, std::span<const glm::dvec3> actual,
                       std::span<const glm::dvec3> expected);

/// The row of something that a device has no room for, which is no failure. To be called where the
/// error is caught: throws it on where it is another.
[[nodiscard]] inline Row refusal(const Error& error, const std::string& group,
                                 const std::string& size, const std::string& peer) {
  if (error.code() != ErrorCode::OutOfMemory) throw;
  Row row;
  row.group = group;
  row.size = size;
  row.peer = peer;
  row.refused = error.what();
  return row;
}

/// Where and of what the figures were measured.
struct Machine {
  std::string cpu;
  unsigned core_count = 0;
  std::uint64_t memory_bytes = 0;
  double load = 0;     ///< of the last minute, before the benchmarks: above 0.5 figures are noisy
  std::string commit;  ///< of the source tree, "-dirty" with changes; "unknown" outside git
};
[[nodiscard]] Machine this_machine();

/// Highest resident memory of this process so far, in bytes.
[[nodiscard]] std::uint64_t peak_memory_bytes();

/// Times and ratios as a Markdown table on standard output.
void print_table(const Machine& machine, const std::vector<Row>& rows);

/// A group that ended with an error.
struct Failure {
  std::string group, reason;
};

/// The same as JSON, as bench.schema.json has it, written through OutputFile. Throws
/// Error{UnwritableOutput}.
void write_json(const std::filesystem::path& path, const Machine& machine,
                const std::vector<Row>& rows, const std::vector<Failure>& failures);

/// A tolerance that no step reaches.
inline constexpr double kNoStop = -1;

// Each prepares its meshes and tables, throws when peers disagree, then measures.

/// One application of the limit masks.
[[nodiscard]] std::vector<Row> bench_update(const Options& options);
/// The whole solve to 1e-6 of the diagonal.
[[nodiscard]] std::vector<Row> bench_solve(const Options& options);
/// The fair net, and one plain step beside it.
[[nodiscard]] std::vector<Row> bench_fair(const Options& options);
/// Topology and limit masks.
[[nodiscard]] std::vector<Row> bench_masks(const Options& options);
/// Tessellation of the limit surface.
[[nodiscard]] std::vector<Row> bench_surface(const Options& options);
/// Rows and faces of a level by patches, and what they are made from.
[[nodiscard]] std::vector<Row> bench_patches(const Options& options);
/// From the bytes of a file to the bytes of a file.
[[nodiscard]] std::vector<Row> bench_job(const Options& options);
#ifdef PLANISH_HAS_VULKAN
/// Copies, and each kernel of a frame beside them: bytes and times; nothing without a Vulkan
/// device, as with the two that follow.
[[nodiscard]] std::vector<Row> bench_kernels(const Options& options);
/// Whole frames of moving points.
[[nodiscard]] std::vector<Row> bench_frame(const Options& options);
/// Many small solves and evaluations in one submission against one as large.
[[nodiscard]] std::vector<Row> bench_many(const Options& options);
#endif
/// Places of a limit surface, closest points and rays; Bfr's Catmull-Clark beside them.
[[nodiscard]] std::vector<Row> bench_query(const Options& options);
/// Moves of a few vertices, and of all, of meshes of several sizes.
[[nodiscard]] std::vector<Row> bench_edit(const Options& options);
/// From a mesh to a level 2 by default, of hubs and large faces beside a torus of as many corners.
[[nodiscard]] std::vector<Row> bench_worst(const Options& options);
/// Catmull-Clark stencils that make a level 2.
[[nodiscard]] std::vector<Row> bench_osd(const Options& options);

/// Torus R = 1, r = 0.4 of about `quad_count` quads, as many around as along.
[[nodiscard]] PolygonMesh torus_grid(std::int32_t quad_count);

/// Torus R = 1, r = 0.4 of about `quad_count` quads whose vertices are moved by up to a fifth of an
/// edge, each cut along either diagonal by lot. The same bits on every call.
[[nodiscard]] PolygonMesh irregular_triangles(std::int32_t quad_count);

/// Icosahedron split `level` times, every vertex moved along its radius by up to 1 %: the initial
/// error of scanned models on an irregular mesh of triangles. The same bits on every call.
[[nodiscard]] PolygonMesh rough_icosphere(int level);

/// Two vertices of `valence` triangles each, off the middle of a rim as uneven as a star's.
[[nodiscard]] PolygonMesh uneven_bipyramid(std::int32_t valence);

/// The mesh as Wavefront OBJ text.
[[nodiscard]] std::string obj_text(const PolygonMesh& mesh);

/// torus_grid of about `point_count` points, each moved by up to a tenth of an edge in every
/// direction, as scanned points lie. The same bits on every call.
[[nodiscard]] PolygonMesh rough_torus(std::int32_t point_count);

/// The points as they are `frame` sixtieths of a second into a motion: twisted about the x axis, to
/// and fro once a second, by up to half a radian a unit of length.
[[nodiscard]] std::vector<glm::vec3> twisted(const PolygonMesh& rest, int frame);

/// Rows of a level of the mesh's Doo-Sabin surface by what stood in place of patches: a chain of
/// stencil tables, made and applied in slices. Both as long as limit points of the level.
void apply_table_chain(const PolygonMesh& mesh, int level, std::span<glm::dvec3> positions,
                       std::span<glm::vec3> normals);

// What the group `edit` moves, on the CPU and on devices.
inline constexpr std::size_t kManyMoves = 1000;
inline constexpr double kWayOfEdit = 0.01;  ///< of the diagonal

/// This way or the other by lot: all vertices by one way would leave nothing to solve.
[[nodiscard]] glm::dvec3 way_of(std::int32_t vertex, double way);

/// The kManyMoves vertices nearest to a vertex, that one among them.
[[nodiscard]] std::vector<std::int32_t> near_vertices(const PolygonMesh& mesh, std::int32_t vertex);

/// kManyMoves vertices all over the mesh.
[[nodiscard]] std::vector<std::int32_t> scattered_vertices(const PolygonMesh& mesh);

/// Moves of a torus' vertices by recorded edits of an embedding host on the best Vulkan device,
/// beside a warm solve and evaluation of all; nothing without one.
[[nodiscard]] std::vector<Row> bench_device_edits(const Options& options, const PolygonMesh& mesh,
                                                  const std::string& size);

}  // namespace planish::bench
