#include <algorithm>

#include "bench/agreement.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "bench/prepared_mesh.h"
#include "planish/backend/cpu_backend.h"
#include "planish/surface/evaluate.h"

namespace planish::bench {

namespace {

// A run takes seconds: its share of noise is small and fewer runs do.
constexpr int kSurfaceRuns = 3;

}  // namespace

std::vector<Row> bench_surface(const Options& options) {
  const PreparedMesh prepared(torus_grid(options.quad_count));
  const auto backend = make_cpu_backend();
  const auto surface_of = [&](int level) {
    EvaluateOptions evaluation;
    evaluation.level = level;
    return evaluate(prepared.mesh, *backend, evaluation);
  };
  // Limit points of the cage's own vertices are the same at every level.
  const std::vector<glm::dvec3> limits = prepared.limits_of(prepared.mesh.positions);
  for (const int level : {1, 2}) {
    const SurfaceMesh surface = surface_of(level);
    require_agreement("surface", std::span(surface.positions).first(limits.size()), limits);
  }

  Group group;
  group.name = "surface";
  group.size = std::to_string(prepared.mesh.face_count()) + " quads";
  group.baseline = "level-1";
  group.peers = {{"level-1", [&] { (void)surface_of(1); }},
                 {"level-2", [&] { (void)surface_of(2); }}};
  return run_group(group, std::min(options.repetitions, kSurfaceRuns));
}

}  // namespace planish::bench
