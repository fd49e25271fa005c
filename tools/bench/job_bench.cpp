#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "bench/agreement.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "planish/backend/cpu_backend.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/obj/read_obj.h"
#include "planish/pipeline/fit.h"
#include "planish/surface/evaluate.h"

namespace planish::bench {

namespace {

// A run takes seconds: its share of noise is small and fewer runs do.
constexpr int kRuns = 3;

struct Job {
  std::string text;
  Backend& backend;
  MeshFile file{};
  Fit result{};
  SurfaceMesh surface{};
  std::vector<std::byte> glb{};

  void read() { file = read_obj(std::as_bytes(std::span(text)), "bench.obj"); }
  void find_cage() { result = fit(file.mesh, backend); }
  void tessellate() { surface = evaluate(result.cage, backend); }
  void encode() { glb = encode_glb(surface, {}); }
  void all() {
    read();
    find_cage();
    tessellate();
    encode();
  }
};

}  // namespace

std::vector<Row> bench_job(const Options& options) {
  const auto backend = make_cpu_backend();
  Job job{obj_text(torus_grid(options.quad_count)), *backend};
  job.all();
  require_agreement("job", std::span(job.surface.positions).first(job.file.mesh.positions.size()),
                    job.file.mesh.positions);

  Group group;
  group.name = "job";
  group.size = std::to_string(job.file.mesh.face_count()) + " quads";
  group.baseline = "whole";
  group.peers = {{"read", [&] { job.read(); }},
                 {"fit", [&] { job.find_cage(); }},
                 {"evaluate-level-2", [&] { job.tessellate(); }},
                 {"encode-glb", [&] { job.encode(); }},
                 {"whole", [&] { job.all(); }}};
  return run_group(group, std::min(options.repetitions, kRuns));
}

}  // namespace planish::bench
