#include <algorithm>
#include <array>
#include <string>

#include "bench/agreement.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "planish/backend/cpu_backend.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"

namespace planish::bench {

namespace {

constexpr int kWorstLevel = 2;
constexpr int kWorstRuns = 5;
// Two 30,000-gons: of larger ones check() finds that limit masks would have too many entries.
constexpr std::int32_t kMostWorstQuads = 45'000;

// A ring of quads between two fans.
PolygonMesh two_fans(int n) {
  const PolygonMesh drum = test::prism(n);
  PolygonMesh mesh;
  mesh.positions = drum.positions;
  for (std::int32_t f = 0; f < drum.face_count(); ++f) {
    const auto face = drum.face(f);
    if (face.size() == 4) {
      mesh.add_face(face);
      continue;
    }
    glm::dvec3 middle(0.0);
    for (const std::int32_t v : face) middle += drum.positions[v] / static_cast<double>(n);
    const std::int32_t hub = mesh.vertex_count();
    mesh.positions.push_back(1.2 * middle);
    for (std::size_t i = 0; i < face.size(); ++i)
      mesh.add_face(std::array{face[i], face[(i + 1) % face.size()], hub});
  }
  return mesh;
}

// Every second corner of both polygons turns inward.
PolygonMesh star_drum(int n) {
  PolygonMesh mesh = test::prism(n);
  for (std::size_t v = 0; v < mesh.positions.size(); v += 2) {
    mesh.positions[v].x *= 0.6;
    mesh.positions[v].y *= 0.6;
  }
  return mesh;
}

PolygonMesh creased_bipyramid(int n) {
  PolygonMesh mesh = test::bipyramid(n);
  for (const std::int32_t edge : {0, n / 3, n / 2})
    for (const std::int32_t hub : {mesh.vertex_count() - 2, mesh.vertex_count() - 1})
      mesh.creases.push_back({edge, hub, kInfiniteSharpness});
  return mesh;
}

}  // namespace

std::vector<Row> bench_worst(const Options& options) {
  const std::int32_t quads = std::min(options.quad_count, kMostWorstQuads);
  const auto backend = make_cpu_backend();
  Group group;
  group.name = "worst";
  group.baseline = "torus";
  const auto add = [&](const std::string& name, const PolygonMesh& mesh) {
    group.peers.push_back({name, [&backend, mesh] {
                             const FittedMesh fitted = fit_mesh(mesh, "bench", *backend);
                             const EvaluateOptions at = fitted.evaluate_options(kWorstLevel);
                             (void)evaluate(fitted.mesh, fitted.fit, *backend, at);
                           }});
  };
  const PolygonMesh torus = torus_grid(quads);
  const auto corners = static_cast<std::int32_t>(torus.face_vertices.size());
  group.size = std::to_string(corners) + " corners each, level " + std::to_string(kWorstLevel);
  add("torus", torus);
  add("drum", test::prism(corners / 6));
  add("star-drum", star_drum(corners / 12 * 2));
  add("two-fans", two_fans(corners / 10));
  add("bipyramid", test::bipyramid(corners / 6));
  add("creased-bipyramid", creased_bipyramid(corners / 6));
  add("open-fan", test::open_fan(std::min(corners / 3, 65'000)));
  return run_group(group, std::min(options.repetitions, kWorstRuns));
}

}  // namespace planish::bench
