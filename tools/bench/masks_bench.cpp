
#include "bench/agreement.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "bench/prepared_mesh.h"
#include "planish/backend/cpu_backend.h"
#include "planish/surface/evaluate.h"

namespace planish::bench {

namespace {

std::vector<Row> bench_masks_of(const std::string& name, PolygonMesh mesh, int repetitions) {
  const PreparedMesh prepared(std::move(mesh));
  // The surface's own tables reach the same limit points by another way: one Doo-Sabin step, then
  // the mean of the points around each vertex.
  EvaluateOptions level_0;
  level_0.level = 0;
  const auto backend = make_cpu_backend();
  require_agreement(name, prepared.limits_of(prepared.mesh.positions),
                    evaluate(prepared.mesh, *backend, level_0).positions);

  const Subdivision subdivision(prepared.topology, prepared.features, Weights::DooSabin);
  Group group;
  group.name = name;
  group.size = std::to_string(prepared.mesh.face_count()) + " faces, " +
               std::to_string(prepared.masks.weights.size()) + " entries";
  group.baseline = "topology";
  group.peers = {{"topology", [&] { const MeshTopology topology(prepared.mesh); }},
                 {"sharp-features",
                  [&] {
                    (void)find_sharp_features(prepared.mesh, prepared.topology,
                                              prepared.mesh.positions, {});
                  }},
                 {"limit-masks", [&] { (void)limit_masks(subdivision); }}};
  return run_group(group, repetitions);
}

}  // namespace

std::vector<Row> bench_masks(const Options& options) {
  std::vector<Row> rows =
      bench_masks_of("masks-torus", torus_grid(options.quad_count), options.repetitions);
  const std::vector<Row> sphere =
      bench_masks_of("masks-sphere", rough_icosphere(options.sphere_level), options.repetitions);
  rows.insert(rows.end(), sphere.begin(), sphere.end());
  return rows;
}

}  // namespace planish::bench
