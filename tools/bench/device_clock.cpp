#include "bench/device_clock.h"

#include <type_traits>

#include "planish/vulkan/device/result.h"

namespace planish::bench {

DeviceClock::DeviceClock(vulkan::VulkanMachine& machine, std::uint32_t query_count)
    : machine_(machine), query_count_(query_count) {
  const std::uint32_t bits = machine.device.capabilities().timestamp_bits;
  if (bits == 0) return;
  mask_ = bits < 64 ? (std::uint64_t(1) << bits) - 1 : ~std::uint64_t(0);
  const vulkan::HostDevice host = machine.device.host_device();
  const auto instance = vulkan::InstanceFunctions::load(host.get_instance_proc, host.instance);
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  instance.vkGetPhysicalDeviceProperties2(host.physical_device, &properties);
  ms_per_tick_ = 1e-6 * static_cast<double>(properties.properties.limits.timestampPeriod);
  const auto load = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(
        instance.vkGetDeviceProcAddr(host.device, name));
  };
  PFN_vkCreateQueryPool create = nullptr;
  load(create, "vkCreateQueryPool");
  load(destroy_, "vkDestroyQueryPool");
  load(reset_, "vkCmdResetQueryPool");
  load(results_, "vkGetQueryPoolResults");
  VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = query_count;
  vulkan::check(create(host.device, &info, nullptr, &pool_), "vkCreateQueryPool");
}

DeviceClock::~DeviceClock() {
  if (pool_) destroy_(machine_.context.device(), pool_, nullptr);
}

void DeviceClock::record_reset(VkCommandBuffer commands) const {
  if (pool_) reset_(commands, pool_, 0, query_count_);
}

void DeviceClock::record(VkCommandBuffer commands, std::uint32_t query) const {
  if (pool_)
    machine_.context.vk().vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool_,
                                              query);
}

std::vector<double> DeviceClock::spans(std::uint32_t first, std::uint32_t count) const {
  if (!pool_ || count == 0) return {};
  std::vector<std::uint64_t> ticks(2 * std::size_t(count));
  vulkan::check(
      results_(machine_.context.device(), pool_, first, 2 * count, ticks.size() * sizeof ticks[0],
               ticks.data(), sizeof ticks[0], VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
      "vkGetQueryPoolResults");
  std::vector<double> result(count);
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = ms_per_tick_ * static_cast<double>((ticks[2 * i + 1] - ticks[2 * i]) & mask_);
  return result;
}

}  // namespace planish::bench
