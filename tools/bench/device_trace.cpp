#include "bench/device_trace.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/vulkan/device/kernels.h"

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

// And what is called in their place.
#define TRACED_FUNCTIONS(X)                  \
  X(vkCreateBuffer, create_buffer)           \
  X(vkCreateBufferView, create_view)         \
  X(vkCreateShaderModule, create_module)     \
  X(vkCreatePipelineLayout, create_layout)   \
  X(vkAllocateDescriptorSets, allocate_sets) \
  X(vkUpdateDescriptorSets, update_sets)     \
  X(vkCmdBindDescriptorSets, bind_sets)      \
  X(vkCmdPipelineBarrier, barrier)           \
  X(vkCmdDispatch, dispatch)                 \
  X(vkCmdDispatchIndirect, dispatch_indirect)
// What the trace calls itself.
#define CALLED_FUNCTIONS(X)      \
  X(vkCreateDescriptorSetLayout) \
  X(vkCmdFillBuffer)             \
  X(vkCmdWriteTimestamp)
#define TRACED_MEMBER(name, ...) PFN_##name name = nullptr;

// The loader's and the driver's functions, and what was seen.
struct Trace {
  PFN_vkGetInstanceProcAddr get_instance_proc = nullptr;
  PFN_vkGetDeviceProcAddr get_device_proc = nullptr;
  TRACED_FUNCTIONS(TRACED_MEMBER)
  CALLED_FUNCTIONS(TRACED_MEMBER)
  std::map<VkBuffer, std::uint64_t> buffers;
  std::map<VkBufferView, Range> views;
  std::map<VkDescriptorSet, Ranges> sets;
  VkPipelineLayout layout = VK_NULL_HANDLE;  // bound last
  VkDescriptorSet set = VK_NULL_HANDLE;
  bool keeps = false;
  vulkan::Timestamps timestamps;
  std::vector<TracedDispatch> dispatches;
  bool logs = false;
  VkDescriptorSetLayout log_layout = VK_NULL_HANDLE;
  VkDescriptorSet log_set = VK_NULL_HANDLE;
  VkBuffer log = VK_NULL_HANDLE;
  std::vector<Access> accesses;

  [[nodiscard]] Range range_of(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize range) const {
    const auto found = buffers.find(buffer);
    if (range != VK_WHOLE_SIZE || found == buffers.end()) return {buffer, offset, range};
    return {buffer, offset, found->second - std::min<std::uint64_t>(offset, found->second)};
  }

  template <class Dispatch>
  void record(VkCommandBuffer commands, bool is_indirect, const Dispatch& dispatch) {
    if (!keeps) return dispatch();
    const auto number = static_cast<std::uint32_t>(dispatches.size());
    const auto query = timestamps.first + 2 * number;
    if (log) mark(commands, number);
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

  void mark(VkCommandBuffer commands, std::uint32_t number) const {
    const VkMemoryBarrier all{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr,
                              VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
                              VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT};
    const auto wait = [&] {
      vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                           VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &all, 0, nullptr, 0, nullptr);
    };
    wait();
    vkCmdFillBuffer(commands, log, kAccessMark * sizeof number, sizeof number, number);
    wait();
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

VkResult VKAPI_CALL create_module(VkDevice device, const VkShaderModuleCreateInfo* info,
                                  const VkAllocationCallbacks* callbacks, VkShaderModule* module) {
  if (!trace.logs) return trace.vkCreateShaderModule(device, info, callbacks, module);
  const std::vector<std::uint32_t> code =
      with_access_log({info->pCode, info->codeSize / sizeof *info->pCode}, trace.accesses);
  VkShaderModuleCreateInfo logging = *info;
  logging.pCode = code.data();
  logging.codeSize = std::span(code).size_bytes();
  return trace.vkCreateShaderModule(device, &logging, callbacks, module);
}

// With the log as one set more.
VkResult VKAPI_CALL create_layout(VkDevice device, const VkPipelineLayoutCreateInfo* info,
                                  const VkAllocationCallbacks* callbacks,
                                  VkPipelineLayout* layout) {
  if (!trace.logs) return trace.vkCreatePipelineLayout(device, info, callbacks, layout);
  if (!trace.log_layout) {
    const VkDescriptorSetLayoutBinding log{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1,
                                           VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    const VkDescriptorSetLayoutCreateInfo of_log{
        VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr, 0, 1, &log};
    const VkResult result =
        trace.vkCreateDescriptorSetLayout(device, &of_log, callbacks, &trace.log_layout);
    if (result != VK_SUCCESS) return result;
  }
  const VkDescriptorSetLayout layouts[] = {info->pSetLayouts[0], trace.log_layout};
  VkPipelineLayoutCreateInfo logging = *info;
  logging.setLayoutCount = 2;
  logging.pSetLayouts = layouts;
  return trace.vkCreatePipelineLayout(device, &logging, callbacks, layout);
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
  if (trace.log)
    trace.vkCmdBindDescriptorSets(commands, point, layout, 1, 1, &trace.log_set, 0, nullptr);
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
#define KEEP_CALLED(function) \
  if (wanted == #function) trace.function = reinterpret_cast<PFN_##function>(found);
  TRACED_FUNCTIONS(REPLACE_TRACED)
  CALLED_FUNCTIONS(KEEP_CALLED)
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

void DeviceTrace::log_accesses(bool is_on) {
  trace.logs = is_on;
  trace.log_layout = VK_NULL_HANDLE;
  trace.accesses.clear();
}

void DeviceTrace::set_log(VkDescriptorSet set, VkBuffer buffer) {
  trace.log_set = set;
  trace.log = buffer;
}

VkDescriptorSetLayout DeviceTrace::log_layout() { return trace.log_layout; }
const std::vector<Access>& DeviceTrace::accesses() { return trace.accesses; }

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

}  // namespace planish::bench
