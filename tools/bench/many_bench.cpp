// Many small meshes in one command buffer against one large mesh.
#include <algorithm>
#include <memory>

#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "planish/core/formatted.h"
#include "planish/mesh/merged_meshes.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/vulkan_backend.h"

namespace planish::bench {

namespace {

using namespace vulkan;

constexpr std::int32_t kMeshes = 64;
constexpr SolveParameters kSteps{.iterations = 16, .measures_last = true};
constexpr std::uint32_t kBytesOfVertex = 24;

// Instances of one mesh, each with points and vertices of its own: Solves of `each` instances.
struct Instances {
  Instances(VulkanMachine& machine, const PolygonMesh& mesh, std::int32_t count,
            std::int32_t each = 1)
      : system(mesh, {.level = 1}), device(machine.context, system) {
    Buffer staging(machine.context, device.upload_bytes(), MemoryUse::Upload);
    device.write_upload(system, staging.mapped().first(device.upload_bytes()));
    staging.flush();
    machine.submitter.run(
        [&](VkCommandBuffer commands) { device.record_upload(commands, staging.handle(), 0); });
    std::vector<glm::vec3> rounded;
    for (std::int32_t i = 0; i < each; ++i)
      rounded.insert(rounded.end(), mesh.positions.begin(), mesh.positions.end());
    for (std::int32_t i = 0; i < count; ++i) {
      const Buffer& given = points.emplace_back(machine.context, rounded.size() * sizeof(glm::vec3),
                                                MemoryUse::Device);
      machine.submitter.upload(whole(given), std::as_bytes(std::span(rounded)));
      const Buffer& target = vertices.emplace_back(
          machine.context, std::uint64_t(each) * system.vertex_count() * kBytesOfVertex,
          MemoryUse::Device);
      solves.push_back(std::make_unique<vulkan::Solve>(
          machine.context, device,
          SolveOptions{.given = {given.handle()},
                       .vertices = {target.handle()},
                       .instances = static_cast<std::uint32_t>(each)}));
      solve_calls.push_back({solves.back().get(), kSteps});
      evaluate_calls.push_back({solves.back().get(), {}});
    }
  }

  System system;
  DeviceSystem device;
  std::vector<Buffer> points, vertices;
  std::vector<std::unique_ptr<vulkan::Solve>> solves;
  std::vector<SolveCall> solve_calls;
  std::vector<EvaluateCall> evaluate_calls;
};

// `count` of the mesh side by side, as one.
PolygonMesh side_by_side(const PolygonMesh& mesh, std::int32_t count) {
  std::vector<PolygonMesh> meshes(static_cast<std::size_t>(count), mesh);
  for (std::int32_t i = 0; i < count; ++i)
    for (glm::dvec3& p : meshes[i].positions) p.x += 3 * i;
  return merged_meshes(meshes).mesh;
}

void add_peers(Group& group, const std::string& name, VulkanMachine& machine,
               const std::shared_ptr<Instances>& instances) {
  const auto add = [&](const std::string& what, auto record) {
    group.peers.push_back({what, [&machine, instances, record] {
                             machine.submitter.run(
                                 [&](VkCommandBuffer commands) { record(commands, *instances); });
                           }});
  };
  add("solve-" + name, [](VkCommandBuffer commands, const Instances& all) {
    record_solves(commands, all.solve_calls);
  });
  add("evaluate-" + name, [](VkCommandBuffer commands, const Instances& all) {
    record_evaluates(commands, all.evaluate_calls);
  });
  if (instances->solves.size() == 1) return;
  add("solve-" + name + "-apart", [](VkCommandBuffer commands, const Instances& all) {
    for (const SolveCall& call : all.solve_calls)
      call.solve->record_solve(commands, call.parameters);
  });
}

}  // namespace

std::vector<Row> bench_many(const Options& options) {
  if (list_vulkan_devices().best < 0) return {};
  VulkanMachine machine({.wanted = options.device}, {});
  // 128,000 points by default, as many as the small ones together.
  // Tori of 4 x 4 quads at least.
  const std::int32_t large = std::max(options.quad_count * 16 / 125, 16 * kMeshes);
  const auto one = std::make_shared<Instances>(machine, torus_grid(large), 1);
  const PolygonMesh small = torus_grid(large / kMeshes);
  const auto many = std::make_shared<Instances>(machine, small, kMeshes);
  const auto instances = std::make_shared<Instances>(machine, small, 1, kMeshes);
  // One System whose mesh has as many components.
  const auto merged = std::make_shared<Instances>(machine, side_by_side(small, kMeshes), 1);
  // So small that what a dispatch costs is all.
  const auto tiny = std::make_shared<Instances>(machine, torus_grid(16), kMeshes);

  Group group;
  group.name = "many";
  const auto points = [](const Instances& all) {
    return formatted("{} of {}", all.solves.size(), all.system.given_count());
  };
  group.size = formatted("{} points, {}, {}; {} steps; vulkan on {}", points(*one), points(*many),
                         points(*tiny), kSteps.iterations, machine.device.capabilities().name);
  group.baseline = "solve-one";
  add_peers(group, "one", machine, one);
  add_peers(group, "merged", machine, merged);
  add_peers(group, "instances", machine, instances);
  add_peers(group, "many", machine, many);
  add_peers(group, "tiny", machine, tiny);
  return run_group(group, options.repetitions);
}

}  // namespace planish::bench
