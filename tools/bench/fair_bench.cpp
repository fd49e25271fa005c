#include <algorithm>
#include <array>
#include <memory>

#include "bench/agreement.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "bench/prepared_mesh.h"
#include "planish/backend/cpu_backend.h"
#include "planish/fair/fair_builder.h"
#include "planish/fair/polish.h"
#include "planish/fair/vertex_frame.h"
#ifdef PLANISH_HAS_VULKAN
#include "planish/vulkan/vulkan_backend.h"
#endif

namespace planish::bench {

namespace {

constexpr std::int32_t kPolishSteps = 8;

PolygonMesh triangulated(const PolygonMesh& quads) {
  PolygonMesh mesh;
  mesh.positions = quads.positions;
  mesh.face_offsets = {0};
  for (std::int32_t f = 0; f < quads.face_count(); ++f) {
    const std::int32_t* v = &quads.face_vertices[quads.face_offsets[f]];
    for (const std::int32_t corner : {v[0], v[1], v[2], v[0], v[2], v[3]})
      mesh.face_vertices.push_back(corner);
    for (int triangle = 0; triangle < 2; ++triangle)
      mesh.face_offsets.push_back(mesh.face_offsets.back() + 3);
  }
  return mesh;
}

// Plain steps of the paper's iteration on tables that are on the device.
Peer plain_peer(const std::string& name, Backend& backend, const PreparedMesh& prepared) {
  const std::shared_ptr<Solve> solve = backend.make_solve(prepared.masks.view());
  solve->begin(prepared.given);
  return {name, [solve] {
            const std::array<StepCoefficients, 1> step = {{{0.0, 1.0}}};
            (void)solve->run(step, kNoStop);
          }};
}

// A net before its polish, and what the polish takes.
struct Unpolished {
  Unpolished(const PreparedMesh& prepared, const Subdivision& subdivision)
      : topology(make_fair_topology(prepared.mesh, subdivision)),
        given(prepared.given),
        offsets(fair_net(prepared.mesh, subdivision, given, {.polish_steps = 0}).state) {
    for (std::size_t c = 0; c < offsets.size(); ++c)
      offsets[c] -= given[topology.corner_vertices[c]];  // no curve points: the torus is closed
    const auto face_normals = unit_face_normals(topology, given);
    std::vector<glm::dvec3> normals(given.size());
    for (std::int32_t v = 0; v < topology.vertex_count; ++v)
      normals[v] = angle_weighted_normal(topology, given, face_normals, v, topology.ring(v));
    directions = polish_directions(topology, normals, std::vector<double>(given.size(), 0.0));
  }
  [[nodiscard]] BendingRows rows() const {
    return make_bending_rows(topology, given, directions, offsets);
  }
  void polish(std::int32_t steps) {
    std::vector<glm::dvec3> moved = offsets;
    apply_heights(topology, directions, polish_heights(topology, rows(), steps), moved);
  }

  FairTopology topology;
  std::span<const glm::dvec3> given;
  std::vector<glm::dvec3> offsets, directions;
};

}  // namespace

std::vector<Row> bench_fair(const Options& options) {
  const PreparedMesh prepared(triangulated(torus_grid(options.quad_count)));
  const Subdivision subdivision(prepared.topology, prepared.features, Weights::DooSabin);
  const FairOptions fair{kPolishSteps, {}};
  const auto cpu = make_cpu_backend({Precision::Float, 0});
  Group group;
  group.name = "fair";
  group.size = std::to_string(prepared.mesh.vertex_count()) + " vertices, triangles";
  group.baseline = "planish-cpu-plain-step";
  const FairOptions unpolished{0, {}};
  Unpolished net(prepared, subdivision);
  group.peers = {
      plain_peer("planish-cpu-plain-step", *cpu, prepared),
      {"planish-cpu-fair",
       [&] { (void)fair_net(prepared.mesh, subdivision, prepared.given, fair); }},
      {"planish-cpu-fair-without-polish",
       [&] { (void)fair_net(prepared.mesh, subdivision, prepared.given, unpolished); }},
      {"planish-cpu-topology", [&] { (void)make_fair_topology(prepared.mesh, subdivision); }},
      {"planish-cpu-polish", [&] { net.polish(kPolishSteps); }},
      {"planish-cpu-polish-rows", [&] { (void)net.rows(); }}};
#ifdef PLANISH_HAS_VULKAN
  std::unique_ptr<Backend> vulkan;
  if (list_vulkan_devices().best >= 0) vulkan = make_vulkan_backend({.device = options.device});
  auto* const builder = dynamic_cast<FairBuilder*>(vulkan.get());
  const FairTopology topology = make_fair_topology(prepared.mesh, subdivision);
  if (builder) {
    group.size += ", " + vulkan->description().name;
    group.baseline = "planish-vulkan-plain-step";
    require_agreement("planish-vulkan-fair",
                      builder->build_fair_net(topology, prepared.given, fair).state,
                      fair_net(prepared.mesh, subdivision, prepared.given, fair).state);
    group.peers.push_back(plain_peer("planish-vulkan-plain-step", *vulkan, prepared));
    group.peers.push_back({"planish-vulkan-fair",
                           [&] { (void)builder->build_fair_net(topology, prepared.given, fair); }});
    group.peers.push_back({"planish-vulkan-fair-without-polish", [&] {
                             (void)builder->build_fair_net(topology, prepared.given, unpolished);
                           }});
  }
#endif
  return run_group(group, std::min(options.repetitions, 3));
}

}  // namespace planish::bench
