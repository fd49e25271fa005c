#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "bench/benchmarks.h"
#include "planish/vulkan/backend/vulkan_machine.h"
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
};

/// The kernel that a layout belongs to, as its file is called; empty for one that is not planish's.
[[nodiscard]] std::string_view kernel_of(const vulkan::Context& context, VkPipelineLayout layout);

/// A query pool of timestamps on a machine's device, which outlives it.
class DeviceClock {
 public:
  DeviceClock(vulkan::VulkanMachine& machine, std::uint32_t query_count);
  ~DeviceClock();
  DeviceClock(const DeviceClock&) = delete;
  DeviceClock& operator=(const DeviceClock&) = delete;

  /// VK_NULL_HANDLE where the device's queue has no timestamps.
  [[nodiscard]] VkQueryPool pool() const { return pool_; }
  /// Before the first timestamp of a command buffer.
  void record_reset(VkCommandBuffer commands) const;
  /// After the work that `commands` holds so far.
  void record(VkCommandBuffer commands, std::uint32_t query) const;
  /// Milliseconds from the timestamp of query `first` + 2 i to the one after it, for i below
  /// `count`; the submission has ended. Empty without a pool.
  [[nodiscard]] std::vector<double> spans(std::uint32_t first, std::uint32_t count) const;

 private:
  vulkan::VulkanMachine& machine_;
  std::uint32_t query_count_;
  VkQueryPool pool_ = VK_NULL_HANDLE;
  double ms_per_tick_ = 0;
  std::uint64_t mask_ = 0;  // of the bits that count
  PFN_vkDestroyQueryPool destroy_ = nullptr;
  PFN_vkCmdResetQueryPool reset_ = nullptr;
  PFN_vkGetQueryPoolResults results_ = nullptr;
};

/// Splits of the surface that a frame's vertices are made at.
inline constexpr int kFrameLevel = 2;
inline constexpr std::uint32_t kFrameVertexBytes = 24;

/// The best Vulkan device, seen by DeviceTrace. Null where there is none; throws Error{NoDevice}
/// where it does not start.
[[nodiscard]] std::unique_ptr<vulkan::VulkanMachine> traced_machine(const Options& options);

/// Everything that a host has for one instance, on a machine that outlives it; tables are there
/// and points are those of `mesh`.
struct DeviceFrame {
  DeviceFrame(vulkan::VulkanMachine& machine, const PolygonMesh& mesh,
              const vulkan::SystemOptions& options);

  /// Another solve of the same tables into the same vertices, of each slot's points in `given`.
  [[nodiscard]] vulkan::Solve make_solve(vulkan::VulkanMachine& machine,
                                         std::initializer_list<VkBuffer> given) const;
  void set_points(vulkan::VulkanMachine& machine, std::span<const glm::vec3> pose) const;

  vulkan::System system;
  vulkan::DeviceSystem tables;
  vulkan::Buffer points, vertices;
  vulkan::Solve solve;
};

}  // namespace planish::bench
