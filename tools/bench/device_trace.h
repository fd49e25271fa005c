#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "bench/spirv_accesses.h"
#include "planish/vulkan/device/context.h"
#include "planish/vulkan/embed.h"

namespace planish::bench {

/// A dispatch as it was recorded.
struct TracedDispatch {
  VkPipelineLayout layout = VK_NULL_HANDLE;  ///< each kernel has its own
  std::uint64_t bound_bytes = 0;             ///< of the ranges that its descriptor set binds
  bool is_indirect = false;                  ///< the device decides how often it runs
  std::uint32_t barriers = 0;                ///< that come before the next dispatch
};

/// Stands between planish and the loader, and sees what is recorded: which ranges of buffers every
/// dispatch binds, so that bytes are counted where they are bound and not by hand. There is one for
/// the process, since Vulkan's functions know no object; used by one thread at a time.
class DeviceTrace {
 public:
  /// For InstanceOptions::get_proc. Null where there is no loader.
  [[nodiscard]] static PFN_vkGetInstanceProcAddr get_proc();

  /// From now on keeps the dispatches that are recorded, until end(). With a pool writes a
  /// timestamp before and one after each, from query `first` on; what comes before a dispatch has
  /// then ended.
  static void begin(const vulkan::Timestamps& timestamps);
  [[nodiscard]] static std::vector<TracedDispatch> end();

  /// Kernels that are compiled while it is on log what they access of storage buffers; see
  /// spirv_accesses.h. They run while `set`, of log_layout(), is their log, the buffer that it
  /// binds; a record's mark is the number of the dispatch since begin().
  static void log_accesses(bool is_on);
  static void set_log(VkDescriptorSet set, VkBuffer buffer);
  [[nodiscard]] static VkDescriptorSetLayout log_layout();
  [[nodiscard]] static const std::vector<Access>& accesses();
};

/// The kernel that a layout belongs to, as its file is called; empty for one that is not planish's.
[[nodiscard]] std::string_view kernel_of(const vulkan::Context& context, VkPipelineLayout layout);

}  // namespace planish::bench
