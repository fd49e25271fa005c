#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
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

// Both polygons are a band along a spiral: one half of their corners turn inward by next to
// nothing.
PolygonMesh spiral_drum(int n) {
  PolygonMesh mesh = test::prism(n);
  constexpr double kTurns = 3;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const int i = v % n, half = n / 2;
    const bool is_outer = i < half;
    const double turns = kTurns * (is_outer ? i : n - 1 - i) / (half - 1);
    const double radius = 1 + 0.5 * turns - (is_outer ? 0 : 0.3);
    const double angle = 2 * std::numbers::pi * turns;
    mesh.positions[v].x = radius * std::cos(angle);
    mesh.positions[v].y = radius * std::sin(angle);
  }
  return mesh;
}

// Closed parts through one another, two hubs and slivers in each.
PolygonMesh crossing_cones(int n) {
  PolygonMesh mesh;
  for (int part = 0; part < 3; ++part) {
    const PolygonMesh cone = test::bipyramid(n);
    const std::int32_t first = mesh.vertex_count();
    for (const glm::dvec3& p : cone.positions) {
      const glm::dvec3 moved = glm::dvec3(1, 1, 3) * p + 0.1 * part;
      mesh.positions.push_back({moved[part], moved[(part + 1) % 3], moved[(part + 2) % 3]});
    }
    for (std::int32_t f = 0; f < cone.face_count(); ++f) {
      std::vector<std::int32_t> face;
      for (const std::int32_t v : cone.face(f)) face.push_back(first + v);
      mesh.add_face(face);
    }
  }
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
  add("spiral-drum", spiral_drum(corners / 12 * 2));
  add("two-fans", two_fans(corners / 10));
  add("bipyramid", test::bipyramid(corners / 6));
  add("creased-bipyramid", creased_bipyramid(corners / 6));
  add("crossing-cones", crossing_cones(corners / 18));
  add("open-fan", test::open_fan(std::min(corners / 3, 65'000)));
  return run_group(group, std::min(options.repetitions, kWorstRuns));
}

}  // namespace planish::bench
