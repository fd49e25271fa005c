#include "bench/device_frame.h"

#include <vector>

#include "bench/device_trace.h"
#include "planish/vulkan/vulkan_backend.h"

namespace planish::bench {

using namespace vulkan;

std::unique_ptr<VulkanMachine> traced_machine(const Options& options) {
  if (list_vulkan_devices().best < 0) return nullptr;
  OwnDeviceOptions device{.wanted = options.device};
  device.instance.get_proc = DeviceTrace::get_proc();
  ContextOptions context;
  context.max_storage_range = options.max_range;
  if (options.hardware_kernels) context.variant = kHardwareVariant;
  return std::make_unique<VulkanMachine>(device, context);
}

DeviceFrame::DeviceFrame(VulkanMachine& machine, const PolygonMesh& mesh,
                         const SystemOptions& options)
    : system(mesh, options),
      tables(machine.context, system),
      points(machine.context, mesh.positions.size() * sizeof(glm::vec3), MemoryUse::Device),
      vertices(machine.context, std::uint64_t(system.vertex_count()) * kFrameVertexBytes,
               MemoryUse::Device),
      solve(make_solve(machine, {points.handle()})) {
  Buffer staging(machine.context, tables.upload_bytes(), MemoryUse::Upload);
  tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
  staging.flush();
  set_points(machine, std::vector<glm::vec3>(mesh.positions.begin(), mesh.positions.end()));
  machine.submitter.run([&](VkCommandBuffer commands) {
    tables.record_upload(commands, staging.handle(), 0);
    solve.record_reset(commands);
  });
}

vulkan::Solve DeviceFrame::make_solve(VulkanMachine& machine,
                                      std::initializer_list<VkBuffer> given) const {
  SolveOptions options{.given = {*given.begin()}, .vertices = {vertices.handle()}};
  for (auto slot = given.begin() + 1; slot != given.end(); ++slot)
    options.further_slots.push_back({{*slot}, options.vertices, {}});
  return {machine.context, tables, options};
}

void DeviceFrame::set_points(VulkanMachine& machine, std::span<const glm::vec3> pose) const {
  machine.submitter.upload({points.handle(), 0, points.size()}, std::as_bytes(pose));
}

}  // namespace planish::bench
