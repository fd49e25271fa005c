#include <algorithm>
#include <cstring>

#include "bench/agreement.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "bench/table_chain.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish::bench {

namespace {

constexpr int kPatchLevel = 2;

// A surface's rows, as SurfaceMesh has them, and its quads.
struct Output {
  explicit Output(std::int64_t row_count, std::int64_t face_count)
      : positions(static_cast<std::size_t>(row_count)),
        normals(positions.size()),
        faces(static_cast<std::size_t>(4 * face_count)) {}

  RawVector<glm::dvec3> positions;
  RawVector<glm::vec3> normals;
  RawVector<std::int32_t> faces;
};

void set_bytes(Output& output, int value) {
  parallel_for(output.positions.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    std::memset(static_cast<void*>(&output.positions[begin]), value, (end - begin) * 24);
    std::memset(static_cast<void*>(&output.normals[begin]), value, (end - begin) * 12);
  });
}

void store(Output& output) {
  parallel_each(output.positions.size(), 1 << 14, [&](std::size_t i) {
    const auto value = static_cast<double>(i & 7);
    output.positions[i] = {value, value + 1, value + 2};
    output.normals[i] = {1.0f, static_cast<float>(value), 0.0f};
  });
}

void evaluate_rows(const DooSabinSurface& base, const PatchSurface& surface, Output& output) {
  const auto tiles = surface.tiles();
  // Tiles of all parts side by side, as SurfaceBlocks hands them out.
  constexpr std::size_t kSteps = 1024;
  std::vector<std::pair<std::size_t, std::size_t>> parts;  // ranges of tiles
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    if (t == 0 || tiles[t].part != tiles[t - 1].part) parts.emplace_back(t, t);
    parts.back().second = t + 1;
  }
  parallel_for(kSteps, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t step = begin; step < end; ++step) {
      for (const auto& [first, last] : parts) {
        const std::size_t count = last - first;
        const std::size_t from = first + count * step / kSteps,
                          to = first + count * (step + 1) / kSteps;
        if (from == to) continue;
        const RowRange rows{
            tiles[from].first_row,
            tiles[to - 1].first_row + tiles[to - 1].row_count - tiles[from].first_row};
        PatchTarget target;
        target.positions = std::span(output.positions)
                               .subspan(static_cast<std::size_t>(rows.first),
                                        static_cast<std::size_t>(rows.count));
        target.normals = std::span(output.normals)
                             .subspan(static_cast<std::size_t>(rows.first),
                                      static_cast<std::size_t>(rows.count));
        (void)surface.rows(base.state(), base.placement(), rows, target);
      }
    }
  });
}

void write_faces(const SurfaceBlocks& blocks, Output& output) {
  const auto count = static_cast<std::size_t>(blocks.info().face_count);
  parallel_for(count, 1 << 14, [&](std::size_t begin, std::size_t end) {
    blocks.face_vertices({static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end - begin)},
                         std::span(output.faces).subspan(4 * begin, 4 * (end - begin)));
  });
}

void require_same(const PolygonMesh& mesh, const PatchSurface& surface,
                  const DooSabinSurface& base) {
  Output patches(surface.numbering().row_count(), 0), tables(surface.numbering().row_count(), 0);
  evaluate_rows(base, surface, patches);
  apply_table_chain(mesh, kPatchLevel, tables.positions, tables.normals);
  // The rows of level 1 are numbered alike.
  const auto count =
      static_cast<std::size_t>(surface.numbering().first_row(PatchNumbering::Part::Corners));
  require_agreement("patches", std::span<const glm::dvec3>(patches.positions).first(count),
                    std::span<const glm::dvec3>(tables.positions).first(count));
}

}  // namespace

std::vector<Row> bench_patches(const Options& options) {
  const PolygonMesh mesh = torus_grid(options.quad_count);
  EvaluateOptions evaluation;
  evaluation.level = kPatchLevel;
  const DooSabinSurface base(mesh, evaluation);
  const PatchSurface surface(base.patches(), {.level = kPatchLevel});
  const PatchSurface narrow(base.patches(),
                            {.level = kPatchLevel, .instructions = PatchInstructions::Baseline});
  const auto blocks = base.level(kPatchLevel);
  require_same(mesh, surface, base);
  Output output(blocks->info().row_count, blocks->info().face_count);
  set_bytes(output, 0);
  write_faces(*blocks, output);

  Group group;
  group.name = "patches";
  group.size = std::to_string(mesh.face_count()) + " quads, level " + std::to_string(kPatchLevel) +
               ", " + std::to_string(blocks->info().row_count) + " rows";
  group.baseline = "store";
  group.peers = {
      {"memset", [&] { set_bytes(output, 1); }},
      {"store", [&] { store(output); }},
      {"topology", [&] { const MeshTopology topology(mesh); }},
      {"classes", [&] { const PatchSurface made(base.patches(), {.level = kPatchLevel}); }},
      {"rows", [&] { evaluate_rows(base, surface, output); }},
      {"rows-baseline", [&] { evaluate_rows(base, narrow, output); }},
      {"faces", [&] { write_faces(*blocks, output); }},
  };
  std::vector<Row> rows = run_group(group, options.repetitions);
  Group tables = group;
  tables.peers = {{"store", [&] { store(output); }},
                  {"planish-tables", [&] {
                     apply_table_chain(mesh, kPatchLevel, output.positions, output.normals);
                   }}};
  for (Row& row : run_group(tables, std::min(options.repetitions, 3))) {
    if (row.peer == "planish-tables") rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace planish::bench
