#include "bench/traced_device.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <map>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/vulkan_backend.h"

namespace planish::bench {
namespace {

// Of a buffer.
struct Range {
  VkBuffer buffer = VK_NULL_HANDLE;
  std::uint64_t offset = 0, bytes = 0;
};
using Ranges = std::map<std::uint32_t, Range>;  // by binding

// What two bindings share counts once: vertices' positions and attributes may lie in one buffer.
std::uint64_t bytes_of(const Ranges& ranges) {
  std::vector<Range> sorted;
  for (const auto& [binding, range] : ranges) sorted.push_back(range);
  std::ranges::sort(sorted, std::less(),
                    [](const Range& range) { return std::pair(range.buffer, range.offset); });
  std::uint64_t bytes = 0, end = 0;
  VkBuffer buffer = VK_NULL_HANDLE;
  for (const Range& range : sorted) {
    if (range.buffer != buffer) end = 0;
    buffer = range.buffer;
    const std::uint64_t range_end = range.offset + range.bytes;
    bytes += range_end - std::clamp(end, range.offset, range_end);
    end = std::max(end, range_end);
  }
  return bytes;
}

// Vulkan's functions, and what is called in their place.
#define TRACED_FUNCTIONS(X)                  \
  X(vkCreateBuffer, create_buffer)           \
  X(vkCreateBufferView, create_view)         \
  X(vkAllocateDescriptorSets, allocate_sets) \
  X(vkUpdateDescriptorSets, update_sets)     \
  X(vkCmdBindDescriptorSets, bind_sets)      \
  X(vkCmdPipelineBarrier, barrier)           \
  X(vkCmdDispatch, dispatch)                 \
  X(vkCmdDispatchIndirect, dispatch_indirect)
#define TRACED_MEMBER(name, own) PFN_##name name = nullptr;

// The loader's and the driver's functions, and what was seen.
struct Trace {
  PFN_vkGetInstanceProcAddr get_instance_proc = nullptr;
  PFN_vkGetDeviceProcAddr get_device_proc = nullptr;
  TRACED_FUNCTIONS(TRACED_MEMBER)
  PFN_vkCmdWriteTimestamp vkCmdWriteTimestamp = nullptr;
  std::map<VkBuffer, std::uint64_t> buffers;
  std::map<VkBufferView, Range> views;
  std::map<VkDescriptorSet, Ranges> sets;
  VkPipelineLayout layout = VK_NULL_HANDLE;  // bound last
  VkDescriptorSet set = VK_NULL_HANDLE;
  bool keeps = false;
  vulkan::Timestamps timestamps;
  std::vector<TracedDispatch> dispatches;

  [[nodiscard]] Range range_of(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize range) const {
    const auto found = buffers.find(buffer);
    if (range != VK_WHOLE_SIZE || found == buffers.end()) return {buffer, offset, range};
    return {buffer, offset, found->second - std::min<std::uint64_t>(offset, found->second)};
  }

  template <class Dispatch>
  void record(VkCommandBuffer commands, bool is_indirect, const Dispatch& dispatch) {
    if (!keeps) return dispatch();
    const auto query = timestamps.first + 2 * static_cast<std::uint32_t>(dispatches.size());
    dispatches.push_back({layout, bytes_of(sets[set]), is_indirect});
    write(commands, query);
    dispatch();
    write(commands, query + 1);
  }

  // At the bottom of the pipe also before a dispatch: the top does not wait for what came before.
  void write(VkCommandBuffer commands, std::uint32_t query) const {
    if (timestamps.pool)
      vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timestamps.pool, query);
  }
} trace;

VkResult VKAPI_CALL create_buffer(VkDevice device, const VkBufferCreateInfo* info,
                                  const VkAllocationCallbacks* callbacks, VkBuffer* buffer) {
  const VkResult result = trace.vkCreateBuffer(device, info, callbacks, buffer);
  if (result == VK_SUCCESS) trace.buffers[*buffer] = info->size;
  return result;
}

VkResult VKAPI_CALL create_view(VkDevice device, const VkBufferViewCreateInfo* info,
                                const VkAllocationCallbacks* callbacks, VkBufferView* view) {
  const VkResult result = trace.vkCreateBufferView(device, info, callbacks, view);
  if (result == VK_SUCCESS)
    trace.views[*view] = trace.range_of(info->buffer, info->offset, info->range);
  return result;
}

VkResult VKAPI_CALL allocate_sets(VkDevice device, const VkDescriptorSetAllocateInfo* info,
                                  VkDescriptorSet* sets) {
  const VkResult result = trace.vkAllocateDescriptorSets(device, info, sets);
  // The handle may have been another set's.
  for (std::uint32_t i = 0; result == VK_SUCCESS && i < info->descriptorSetCount; ++i)
    trace.sets[sets[i]].clear();
  return result;
}

void VKAPI_CALL update_sets(VkDevice device, std::uint32_t write_count,
                            const VkWriteDescriptorSet* writes, std::uint32_t copy_count,
                            const VkCopyDescriptorSet* copies) {
  for (std::uint32_t i = 0; i < write_count; ++i) {
    const VkWriteDescriptorSet& write = writes[i];
    for (std::uint32_t k = 0; k < write.descriptorCount; ++k) {
      Range& range = trace.sets[write.dstSet][write.dstBinding + k];
      if (write.descriptorType == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER)
        range = trace.views[write.pTexelBufferView[k]];
      else
        range = trace.range_of(write.pBufferInfo[k].buffer, write.pBufferInfo[k].offset,
                               write.pBufferInfo[k].range);
    }
  }
  trace.vkUpdateDescriptorSets(device, write_count, writes, copy_count, copies);
}

void VKAPI_CALL bind_sets(VkCommandBuffer commands, VkPipelineBindPoint point,
                          VkPipelineLayout layout, std::uint32_t first, std::uint32_t count,
                          const VkDescriptorSet* sets, std::uint32_t offset_count,
                          const std::uint32_t* offsets) {
  trace.layout = layout;
  trace.set = sets[0];
  trace.vkCmdBindDescriptorSets(commands, point, layout, first, count, sets, offset_count, offsets);
}

void VKAPI_CALL barrier(VkCommandBuffer commands, VkPipelineStageFlags from,
                        VkPipelineStageFlags to, VkDependencyFlags flags, std::uint32_t count,
                        const VkMemoryBarrier* barriers, std::uint32_t buffer_count,
                        const VkBufferMemoryBarrier* buffer_barriers, std::uint32_t image_count,
                        const VkImageMemoryBarrier* image_barriers) {
  if (trace.keeps && !trace.dispatches.empty()) ++trace.dispatches.back().barriers;
  trace.vkCmdPipelineBarrier(commands, from, to, flags, count, barriers, buffer_count,
                             buffer_barriers, image_count, image_barriers);
}

void VKAPI_CALL dispatch(VkCommandBuffer commands, std::uint32_t x, std::uint32_t y,
                         std::uint32_t z) {
  trace.record(commands, false, [&] { trace.vkCmdDispatch(commands, x, y, z); });
}

void VKAPI_CALL dispatch_indirect(VkCommandBuffer commands, VkBuffer buffer, VkDeviceSize offset) {
  trace.record(commands, true, [&] { trace.vkCmdDispatchIndirect(commands, buffer, offset); });
}

PFN_vkVoidFunction VKAPI_CALL get_device_proc(VkDevice device, const char* name) {
  const PFN_vkVoidFunction found = trace.get_device_proc(device, name);
  if (!found) return nullptr;
  const std::string_view wanted = name;
#define REPLACE_TRACED(function, own)                         \
  if (wanted == #function) {                                  \
    trace.function = reinterpret_cast<PFN_##function>(found); \
    return reinterpret_cast<PFN_vkVoidFunction>(own);         \
  }
  TRACED_FUNCTIONS(REPLACE_TRACED)
  if (wanted == "vkCmdWriteTimestamp")
    trace.vkCmdWriteTimestamp = reinterpret_cast<PFN_vkCmdWriteTimestamp>(found);
  return found;
}

PFN_vkVoidFunction VKAPI_CALL get_instance_proc(VkInstance instance, const char* name) {
  const PFN_vkVoidFunction found = trace.get_instance_proc(instance, name);
  if (!found || std::strcmp(name, "vkGetDeviceProcAddr") != 0) return found;
  trace.get_device_proc = reinterpret_cast<PFN_vkGetDeviceProcAddr>(found);
  return reinterpret_cast<PFN_vkVoidFunction>(get_device_proc);
}

}  // namespace

PFN_vkGetInstanceProcAddr DeviceTrace::get_proc() {
  // Never closed: drivers' threads may outlive whoever asked.
  static void* const library = ::dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
  if (!library) return nullptr;
  trace.get_instance_proc =
      reinterpret_cast<PFN_vkGetInstanceProcAddr>(::dlsym(library, "vkGetInstanceProcAddr"));
  return trace.get_instance_proc ? get_instance_proc : nullptr;
}

void DeviceTrace::begin(const vulkan::Timestamps& timestamps) {
  trace.dispatches.clear();
  trace.timestamps = timestamps;
  trace.keeps = true;
}

std::vector<TracedDispatch> DeviceTrace::end() {
  trace.keeps = false;
  trace.timestamps = {};
  return std::exchange(trace.dispatches, {});
}

std::string_view kernel_of(const vulkan::Context& context, VkPipelineLayout layout) {
  constexpr std::string_view kPrefix = "planish ";
  for (std::size_t i = 0; i < vulkan::kKernelCount; ++i) {
    const auto kernel = static_cast<vulkan::Kernel>(i);
    if (context.pipelines()[kernel].layout != layout) continue;
    const std::string_view name = vulkan::source_of(kernel).name;
    return name.starts_with(kPrefix) ? name.substr(kPrefix.size()) : name;
  }
  return {};
}

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
