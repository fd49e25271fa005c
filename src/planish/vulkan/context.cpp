#include "planish/vulkan/context.h"

#include <algorithm>

#include "planish/core/error.h"

namespace planish::vulkan {

namespace {

// A work group's fixed costs weigh more where a CPU plays the device.
constexpr std::uint32_t kChunksPerGroupSoftware = 4;
constexpr std::uint32_t kChunksPerGroup = 1;

Capabilities usable_capabilities(const HostDevice& host) {
  Capabilities capabilities =
      query_capabilities(host.get_instance_proc, host.instance, host.physical_device);
  if (!capabilities.usable)
    throw Error(ErrorCode::NoDevice, capabilities.name + " " + capabilities.reason);
  return capabilities;
}

template <class Number>
Number lowered(Number limit, Number option) {
  return option ? std::min(limit, option) : limit;
}

DeviceFunctions load_functions(const HostDevice& host) {
  const InstanceFunctions functions =
      InstanceFunctions::load(host.get_instance_proc, host.instance);
  return DeviceFunctions::load(functions.vkGetDeviceProcAddr, host.device);
}

}  // namespace

Context::Context(const HostDevice& host, const ContextOptions& options)
    : device_(host.device),
      callbacks_(host.allocation_callbacks),
      capabilities_(usable_capabilities(host)),
      max_storage_range_(
          lowered(std::min(capabilities_.max_storage_range, capabilities_.max_allocation),
                  options.max_storage_range)),
      max_group_count_(lowered(capabilities_.max_group_count, options.max_group_count)),
      chunks_per_group_(options.chunks_per_group           ? options.chunks_per_group
                        : capabilities_.kind == "software" ? kChunksPerGroupSoftware
                                                           : kChunksPerGroup),
      functions_(load_functions(host)),
      memory_(functions_, device_, capabilities_, callbacks_, host.memory),
      pipelines_(functions_, device_, host.pipeline_cache, callbacks_, chunks_per_group_) {}

}  // namespace planish::vulkan
