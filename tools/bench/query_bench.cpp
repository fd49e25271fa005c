#include <malloc.h>
#include <oneapi/tbb/task_arena.h>
#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <memory>
#include <random>

#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "planish/core/parallel.h"
#include "planish/limit/surface_queries.h"

namespace planish::bench {

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
