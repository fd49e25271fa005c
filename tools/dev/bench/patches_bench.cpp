#include <malloc.h>
#include <oneapi/tbb/task_arena.h>
#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <random>

#include "bench/benchmarks.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/queries/surface_queries.h"
#include "planish/solve/stencil_table.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/surface_blocks.h"
#include "support/doo_sabin_tables.h"

namespace planish::bench {

void apply_table_chain(const PolygonMesh& mesh, int level, std::span<glm::dvec3> positions,
                       std::span<glm::vec3> normals) {
  constexpr std::int64_t kSlice = 1 << 17;
  test::QuadSplit split(mesh);
  split.refine(level);
  const SharpFeatures features = find_sharp_features(mesh, split.topology(), mesh.positions, {});
  const test::SubdivisionChain subdivision(split, features, Weights::DooSabin);
  std::vector<glm::dvec3> points = mesh.positions;
  for (int l = 1; l <= level; ++l) {
    const std::int64_t size = subdivision.state_layout(l).size;
    std::vector<glm::dvec3> next(static_cast<std::size_t>(size));
    for (const RowRange rows : ranges_of(size, kSlice)) {
      apply(step_table(subdivision, l, rows).view(), points,
            std::span(next).subspan(static_cast<std::size_t>(rows.first),
                                    static_cast<std::size_t>(rows.count)));
    }
    points = std::move(next);
  }
  const test::LimitRows limits(subdivision, level);
  for (const RowRange rows : ranges_of(limits.count(), kSlice)) {
    const auto first = static_cast<std::size_t>(rows.first);
    const auto count = static_cast<std::size_t>(rows.count);
    apply_limit(limit_table(subdivision, limits, rows).view(), points,
                positions.subspan(first, count), normals.subspan(first, count));
  }
}

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

namespace {

namespace Bfr = OpenSubdiv::Bfr;
namespace Far = OpenSubdiv::Far;

using Factory = Bfr::RefinerSurfaceFactory<>;
using Surface = Bfr::Surface<double>;

// Catmull-Clark by OpenSubdiv's Bfr, over the same mesh.
class BfrSurface {
 public:
  explicit BfrSurface(const PolygonMesh& mesh) : mesh_(mesh) {
    std::vector<int> sizes;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      sizes.push_back(static_cast<int>(mesh.face(f).size()));
    Far::TopologyDescriptor descriptor;
    descriptor.numVertices = mesh.vertex_count();
    descriptor.numFaces = mesh.face_count();
    descriptor.numVertsPerFace = sizes.data();
    descriptor.vertIndicesPerFace = mesh.face_vertices.data();
    using Refiners = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    refiner_.reset(Refiners::Create(descriptor, Refiners::Options(OpenSubdiv::Sdc::SCHEME_CATMARK,
                                                                  OpenSubdiv::Sdc::Options())));
    factory_ = std::make_unique<Factory>(*refiner_, Factory::Options());
  }

  // One place in each corner's quarter of each face, with second derivatives.
  void evaluate(std::vector<SurfacePoint>& points) const {
    const double* const positions = &mesh_.positions[0].x;
    parallel_for(static_cast<std::size_t>(mesh_.face_count()), 256,
                 [&](std::size_t begin, std::size_t end) {
                   Surface surface;
                   std::vector<double> patch;
                   for (std::size_t f = begin; f < end; ++f) {
                     factory_->InitVertexSurface(static_cast<int>(f), &surface);
                     patch.resize(3 * static_cast<std::size_t>(surface.GetNumPatchPoints()));
                     surface.PreparePatchPoints(positions, 3, patch.data(), 3);
                     SurfacePoint* const corners = &points[mesh_.face_offsets[f]];
                     const auto size = static_cast<int>(mesh_.face(static_cast<int>(f)).size());
                     for (int i = 0; i < size; ++i) {
                       double uv[2];
                       surface.GetParameterization().GetVertexCoord(i, uv);
                       uv[0] += uv[0] > 0.5 && size == 4 ? -0.2 : 0.2;
                       uv[1] += uv[1] > 0.5 && size == 4 ? -0.2 : 0.2;
                       SurfacePoint& p = corners[i];
                       surface.Evaluate(uv, patch.data(), 3, &p.position.x, &p.du.x, &p.dv.x,
                                        &p.duu.x, &p.duv.x, &p.dvv.x);
                     }
                   }
                 });
  }

 private:
  const PolygonMesh& mesh_;
  std::unique_ptr<Far::TopologyRefiner> refiner_;
  std::unique_ptr<Factory> factory_;
};

void add_rows(std::vector<Row>& rows, const Group& group, int repetitions) {
  const std::vector<Row> measured = run_group(group, repetitions);
  rows.insert(rows.end(), measured.begin(), measured.end());
}

// What stays allocated of what is made, on this thread's heap.
template <class Make>
double heap_bytes_of(const Make& make) {
  const auto taken = [] {
    const struct mallinfo2 info = mallinfo2();
    return static_cast<double>(info.uordblks + info.hblkhd);
  };
  double bytes = 0;
  oneapi::tbb::task_arena one(1);
  one.execute([&] {
    const double before = taken();
    const auto made = make();
    bytes = taken() - before;
  });
  return bytes;
}

// From a mesh to what answers; Bfr's factory keeps what surfaces of faces leave with it.
void bench_set_up(const PolygonMesh& mesh, const std::string& name, const Options& options,
                  std::vector<Row>& rows) {
  const auto make_bfr = [&] {
    auto made = std::make_unique<BfrSurface>(mesh);
    std::vector<SurfacePoint> points(mesh.face_vertices.size());
    made->evaluate(points);
    return made;
  };
  const auto make_limit = [&] {
    return std::make_unique<LimitSurface>(
        std::make_shared<const DooSabinSurface>(mesh, EvaluateOptions{}));
  };
  std::vector<Row> measured = run_group({"query-set-up",
                                         name,
                                         "bfr-catmull-clark",
                                         {{"bfr-catmull-clark", [&] { (void)BfrSurface(mesh); }},
                                          {"planish", [&] { (void)make_limit(); }}}},
                                        options.repetitions);
  measured[0].figures = {{"heap_bytes", heap_bytes_of(make_bfr)}};
  measured[1].figures = {{"heap_bytes", heap_bytes_of(make_limit)}};
  rows.insert(rows.end(), measured.begin(), measured.end());
}

void bench_mesh(const PolygonMesh& mesh, const std::string& name, const Options& options,
                std::vector<Row>& rows) {
  bench_set_up(mesh, name, options, rows);
  const auto base = std::make_shared<const DooSabinSurface>(mesh, EvaluateOptions{});
  const LimitSurface surface(base);
  const MeshTopology& topology = surface.topology();
  std::vector<SurfaceParameter> places;
  for (std::int32_t c = 0; c < topology.corner_count(); ++c)
    places.push_back(surface_parameter(topology, c, 0.4, 0.4));
  std::vector<SurfaceParameter> shuffled = places;
  std::ranges::shuffle(shuffled, std::mt19937(1));
  std::vector<SurfacePoint> points(places.size());
  const BfrSurface bfr(mesh);
  const std::string size = name + ", " + std::to_string(places.size()) + " places";
  add_rows(rows,
           {"query-evaluate",
            size,
            "bfr-catmull-clark",
            {{"bfr-catmull-clark", [&] { bfr.evaluate(points); }},
             {"planish", [&] { surface.evaluate(places, points); }},
             {"planish-any-order", [&] { surface.evaluate(shuffled, points); }}}},
           options.repetitions);

  const SurfaceQueries queries(surface);
  constexpr std::size_t kQuestions = 2'000;
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  const auto beside = [&](double off) {
    std::vector<glm::dvec3> result;
    for (std::size_t i = 0; i < kQuestions; ++i) {
      const SurfacePoint on = surface.evaluate(shuffled[i % shuffled.size()]);
      result.push_back(on.position + off * base->placement().diagonal * normal(random) * on.normal);
    }
    return result;
  };
  const std::vector<glm::dvec3> near = beside(1e-4), far = beside(1e-2);
  std::vector<ClosestPoint> answers(kQuestions);
  const auto first_hits = [&](const std::vector<glm::dvec3>& from) {
    parallel_each(from.size(), 16, [&](std::size_t i) {
      const auto hit = queries.first_hit({from[i], base->placement().centre - from[i]});
      answers[i].distance = hit ? hit->t : -1;
    });
  };
  add_rows(rows,
           {"query-closest",
            name + ", " + std::to_string(kQuestions) + " points",
            "closest-1e-4",
            {{"closest-1e-4", [&] { queries.closest(near, answers); }},
             {"closest-1e-2", [&] { queries.closest(far, answers); }},
             {"first-hit", [&] { first_hits(far); }},
             {"make-tree", [&] { (void)CornerTree(surface); }}}},
           options.repetitions);
}

}  // namespace

std::vector<Row> bench_query(const Options& options) {
  std::vector<Row> rows;
  bench_mesh(torus_grid(options.quad_count), "torus", options, rows);
  bench_mesh(rough_icosphere(options.sphere_level), "icosphere", options, rows);
  return rows;
}

}  // namespace planish::bench
