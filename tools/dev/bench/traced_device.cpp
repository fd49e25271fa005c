#include "bench/traced_device.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <map>
#include <span>
#include <stdexcept>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/vulkan_backend.h"

namespace planish::bench {
namespace {

using Words = std::vector<std::uint32_t>;

// Numbers of the SPIR-V specification, version 1.3.
enum Op : std::uint32_t {
  OpEntryPoint = 15,
  OpTypeVoid = 19,
  OpTypeBool = 20,
  OpTypeInt = 21,
  OpTypeFloat = 22,
  OpTypeVector = 23,
  OpTypeArray = 28,
  OpTypeRuntimeArray = 29,
  OpTypeStruct = 30,
  OpTypePointer = 32,
  OpTypeFunction = 33,
  OpConstant = 43,
  OpFunction = 54,
  OpFunctionParameter = 55,
  OpFunctionEnd = 56,
  OpFunctionCall = 57,
  OpVariable = 59,
  OpLoad = 61,
  OpStore = 62,
  OpAccessChain = 65,
  OpArrayLength = 68,
  OpDecorate = 71,
  OpMemberDecorate = 72,
  OpCompositeExtract = 81,
  OpIAdd = 128,
  OpIMul = 132,
  OpSelect = 169,
  OpULessThanEqual = 178,
  OpAtomicExchange = 229,
  OpAtomicIAdd = 234,
  OpAtomicXor = 242,
  OpLabel = 248,
  OpReturn = 253,
};
enum Decoration : std::uint32_t {
  Block = 2,
  ArrayStride = 6,
  BuiltIn = 11,
  Binding = 33,
  DescriptorSet = 34,
  Offset = 35,
};
constexpr std::uint32_t kInput = 1, kStorageBuffer = 12;  // storage classes
constexpr std::uint32_t kGlobalInvocationId = 28;
constexpr std::uint32_t kDeviceScope = 1;
constexpr std::uint32_t kHeadWords = 5, kBoundWord = 3;
constexpr std::uint32_t kWordBytes = 4;

struct Instruction {
  std::uint32_t op;
  std::span<const std::uint32_t> operands;
};

void put(Words& to, std::uint32_t op, std::span<const std::uint32_t> operands) {
  to.push_back(static_cast<std::uint32_t>(operands.size() + 1) << 16 | op);
  to.insert(to.end(), operands.begin(), operands.end());
}
void put(Words& to, std::uint32_t op, std::initializer_list<std::uint32_t> operands) {
  put(to, op, std::span(operands.begin(), operands.size()));
}

class Rewriter {
 public:
  Rewriter(std::span<const std::uint32_t> module, std::vector<Access>& accesses)
      : head_(module.first(kHeadWords)), bound_(module[kBoundWord]), accesses_(accesses) {
    for (std::size_t i = kHeadWords; i < module.size(); i += module[i] >> 16)
      take({module[i] & 0xffff, module.subspan(i + 1, (module[i] >> 16) - 1)});
  }

  Words rewrite() {
    declare();
    const Words log_function = make_log_function();
    Words bodies;
    for (const Instruction& instruction : functions_) add(instruction, bodies);
    Words module(head_.begin(), head_.end());
    for (const Instruction& instruction : preamble_) {
      Words operands(instruction.operands.begin(), instruction.operands.end());
      if (instruction.op == OpEntryPoint && adds_invocation_) operands.push_back(invocation_);
      put(module, instruction.op, operands);
    }
    for (const Words* part :
         std::initializer_list<const Words*>{&decorations_, &types_, &bodies, &log_function})
      module.insert(module.end(), part->begin(), part->end());
    module[kBoundWord] = bound_;
    return module;
  }

 private:
  void take(const Instruction& instruction) {
    const auto [op, operands] = instruction;
    if (op == OpDecorate && operands.size() == 3)
      decorated_[{operands[0], operands[1]}] = operands[2];
    if (op == OpMemberDecorate && operands[2] == Offset)
      offsets_[{operands[0], operands[1]}] = operands[3];
    if (op == OpFunction || !functions_.empty()) {
      functions_.push_back(instruction);
    } else if (op == OpTypeVoid || !types_.empty()) {
      declared_.push_back(instruction);
      put(types_, op, operands);
      const bool is_type = op >= OpTypeVoid && op <= OpTypeFunction;
      typed_[operands[is_type ? 0 : 1]] = instruction;
    } else {
      preamble_.push_back(instruction);
    }
  }

  // The type of the same words, which may be there only once.
  std::uint32_t type(std::uint32_t op, std::initializer_list<std::uint32_t> operands) {
    for (const Instruction& there : declared_)
      if (there.op == op && std::ranges::equal(there.operands.subspan(1), operands))
        return there.operands[0];
    return new_type(op, operands);
  }
  std::uint32_t new_type(std::uint32_t op, std::initializer_list<std::uint32_t> operands) {
    Words all = {bound_++};
    all.insert(all.end(), operands.begin(), operands.end());
    put(types_, op, all);
    return all[0];
  }
  std::uint32_t constant(std::uint32_t value) {
    const auto [place, is_new] = constants_.try_emplace(value, bound_);
    if (is_new) put(types_, OpConstant, {word_, bound_++, value});
    return place->second;
  }
  std::uint32_t variable(std::uint32_t pointer, std::uint32_t storage) {
    put(types_, OpVariable, {pointer, bound_, storage});
    return bound_++;
  }

  void declare() {
    word_ = type(OpTypeInt, {32, 0});
    void_ = type(OpTypeVoid, {});
    bool_ = type(OpTypeBool, {});
    words_ = type(OpTypeVector, {word_, 3});
    word_pointer_ = type(OpTypePointer, {kStorageBuffer, word_});
    function_type_ = type(OpTypeFunction, {void_, word_, word_});
    const std::uint32_t array = new_type(OpTypeRuntimeArray, {word_});
    const std::uint32_t block = new_type(OpTypeStruct, {array});
    log_ = variable(new_type(OpTypePointer, {kStorageBuffer, block}), kStorageBuffer);
    put(decorations_, OpDecorate, {array, ArrayStride, kWordBytes});
    put(decorations_, OpDecorate, {block, Block});
    put(decorations_, OpMemberDecorate, {block, 0, Offset, 0});
    put(decorations_, OpDecorate, {log_, DescriptorSet, 1});
    put(decorations_, OpDecorate, {log_, Binding, 0});
    for (const auto& [of, value] : decorated_)
      if (of.second == BuiltIn && value == kGlobalInvocationId) invocation_ = of.first;
    adds_invocation_ = invocation_ == 0;
    if (!adds_invocation_) return;
    invocation_ = variable(type(OpTypePointer, {kInput, words_}), kInput);
    put(decorations_, OpDecorate, {invocation_, BuiltIn, kGlobalInvocationId});
  }

  // void log(access, offset): a record.
  Words make_log_function() {
    log_function_ = bound_++;
    const std::uint32_t access = bound_++, offset = bound_++;
    Words body;
    const auto value = [&](std::uint32_t op, std::uint32_t of_type,
                           std::initializer_list<std::uint32_t> operands) {
      Words all = {of_type, bound_++};
      all.insert(all.end(), operands.begin(), operands.end());
      put(body, op, all);
      return all[1];
    };
    const auto place = [&](std::uint32_t index) {
      return value(OpAccessChain, word_pointer_, {log_, constant(0), index});
    };
    put(body, OpFunction, {void_, log_function_, 0, function_type_});
    put(body, OpFunctionParameter, {word_, access});
    put(body, OpFunctionParameter, {word_, offset});
    put(body, OpLabel, {bound_++});
    const std::uint32_t next =
        value(OpAtomicIAdd, word_,
              {place(constant(0)), constant(kDeviceScope), constant(0), constant(kAccessWords)});
    const std::uint32_t end = value(OpIAdd, word_, {next, constant(kAccessWords)});
    const std::uint32_t length = value(OpArrayLength, word_, {log_, 0});
    const std::uint32_t fits = value(OpULessThanEqual, bool_, {end, length});
    const std::uint32_t first = value(OpSelect, word_, {fits, next, constant(kFirstAccess)});
    const std::uint32_t mark = value(OpLoad, word_, {place(constant(kAccessMark))});
    const std::uint32_t invocations = value(OpLoad, words_, {invocation_});
    const std::uint32_t invocation = value(OpCompositeExtract, word_, {invocations, 0});
    std::uint32_t k = 0;
    for (const std::uint32_t word : {mark, access, invocation, offset})
      put(body, OpStore, {place(value(OpIAdd, word_, {first, constant(k++)})), word});
    put(body, OpReturn, {});
    put(body, OpFunctionEnd, {});
    return body;
  }

  void add(const Instruction& instruction, Words& to) {
    const auto [op, operands] = instruction;
    if (op == OpLoad) log(operands[2], true, false, to);
    if (op == OpStore) log(operands[0], false, true, to);
    if (op >= OpAtomicExchange && op <= OpAtomicXor) log(operands[2], true, true, to);
    put(to, op, operands);
    if (op == OpAccessChain) follow(operands, to);
  }

  struct Pointer {
    std::uint32_t offset, bytes;
  };

  // Where a chain of indices leads to, in bytes from the start of its buffer.
  void follow(std::span<const std::uint32_t> chain, Words& to) {
    const auto base = typed_.find(chain[2]);
    if (base == typed_.end() || base->second.op != OpVariable ||
        base->second.operands[2] != kStorageBuffer)
      return;
    std::uint32_t at = typed_.at(base->second.operands[0]).operands[2];
    std::uint32_t sum = constant(0);
    for (const std::uint32_t index : chain.subspan(3)) {
      const auto [op, operands] = typed_.at(at);
      if (op == OpTypeStruct) {
        const std::uint32_t member = typed_.at(index).operands[2];
        sum = add_words(OpIAdd, sum, constant(offsets_.at({at, member})), to);
        at = operands[1 + member];
      } else {
        const std::uint32_t stride =
            op == OpTypeVector ? kWordBytes : decorated_.at({at, ArrayStride});
        sum = add_words(OpIAdd, sum, add_words(OpIMul, index, constant(stride), to), to);
        at = operands[1];
      }
    }
    pointers_[chain[1]] = {sum, bytes_of(at)};
  }
  std::uint32_t add_words(std::uint32_t op, std::uint32_t a, std::uint32_t b, Words& to) {
    put(to, op, {word_, bound_, a, b});
    return bound_++;
  }

  [[nodiscard]] std::uint32_t bytes_of(std::uint32_t type) const {
    const auto [op, operands] = typed_.at(type);
    if (op == OpTypeVector) return operands[2] * kWordBytes;
    if (op != OpTypeStruct) return kWordBytes;
    std::uint32_t bytes = 0;
    for (const std::uint32_t member : operands.subspan(1)) bytes += bytes_of(member);
    return bytes;
  }

  void log(std::uint32_t pointer, bool reads, bool writes, Words& to) {
    const auto found = pointers_.find(pointer);
    if (found == pointers_.end()) return;
    put(to, OpFunctionCall,
        {void_, bound_++, log_function_, constant(static_cast<std::uint32_t>(accesses_.size())),
         found->second.offset});
    accesses_.push_back({found->second.bytes, reads, writes});
  }

  std::span<const std::uint32_t> head_;
  std::uint32_t bound_;
  std::vector<Access>& accesses_;
  std::vector<Instruction> preamble_, declared_, functions_;
  std::map<std::uint32_t, Instruction> typed_;  // types, constants and variables by their number
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> decorated_, offsets_;
  std::map<std::uint32_t, std::uint32_t> constants_;
  std::map<std::uint32_t, Pointer> pointers_;
  Words decorations_, types_;
  std::uint32_t word_ = 0, void_ = 0, bool_ = 0, words_ = 0, word_pointer_ = 0, function_type_ = 0;
  std::uint32_t log_ = 0, invocation_ = 0, log_function_ = 0;
  bool adds_invocation_ = false;
};

}  // namespace

std::vector<std::uint32_t> with_access_log(std::span<const std::uint32_t> module,
                                           std::vector<Access>& accesses) {
  return Rewriter(module, accesses).rewrite();
}

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

namespace {

constexpr std::uint64_t kLogBytes = 128u << 20;  // which every device's bindings may have
constexpr std::uint32_t kWarpLanes = 32, kSectorBytes = 32;

struct Record {
  std::uint32_t dispatch, access, invocation, offset;
};
static_assert(sizeof(Record) == kAccessWords * sizeof(std::uint32_t));

// A piece that an access touches in a round of its loops.
struct Sector {
  std::uint32_t access, warp, round, number;
  auto operator<=>(const Sector&) const = default;
};

// Of one dispatch. A lane's records of an access are in the order of its rounds.
AccessTotal total_of(std::span<Record> records) {
  std::ranges::stable_sort(records, {}, [](const Record& record) {
    return std::tuple(record.access, record.invocation);
  });
  AccessTotal total;
  std::vector<Sector> sectors;
  std::uint32_t round = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const auto& [dispatch, number, invocation, offset] = records[i];
    const bool goes_on =
        i > 0 && records[i - 1].access == number && records[i - 1].invocation == invocation;
    round = goes_on ? round + 1 : 0;
    total.longest_walk = std::max<std::uint64_t>(total.longest_walk, round + 1);
    const Access& access = DeviceTrace::accesses().at(number);
    if (access.reads) total.read_bytes += access.bytes;
    if (access.writes) total.written_bytes += access.bytes;
    const std::uint32_t last = (offset + access.bytes - 1) / kSectorBytes;
    for (std::uint32_t sector = offset / kSectorBytes; sector <= last; ++sector)
      sectors.push_back({number, invocation / kWarpLanes, round, sector});
  }
  std::ranges::sort(sectors);
  const auto beyond = std::ranges::unique(sectors);
  total.transactions = static_cast<std::uint64_t>(beyond.begin() - sectors.begin());
  return total;
}

}  // namespace

AccessLog::AccessLog(const Options& options) {
  DeviceTrace::log_accesses(true);
  Options of_hardware = options;
  of_hardware.hardware_kernels = true;
  of_hardware.max_range = 0;  // the log needs a binding of its own
  machine_ = traced_machine(of_hardware);
  records_ = Buffer(machine_->context, kLogBytes, MemoryUse::Download, "log of accesses");
  bind();
  clear();
}

void AccessLog::bind() {
  const Context& context = machine_->context;
  const DeviceFunctions& vk = context.vk();
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1};
  const VkDescriptorPoolCreateInfo pool{
      VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, 1, 1, &size};
  check(vk.vkCreateDescriptorPool(context.device(), &pool, nullptr, &pool_),
        "vkCreateDescriptorPool");
  const VkDescriptorSetLayout layout = DeviceTrace::log_layout();
  const VkDescriptorSetAllocateInfo wanted{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr,
                                           pool_, 1, &layout};
  VkDescriptorSet set = VK_NULL_HANDLE;
  check(vk.vkAllocateDescriptorSets(context.device(), &wanted, &set), "vkAllocateDescriptorSets");
  const VkDescriptorBufferInfo buffer{records_.handle(), 0, VK_WHOLE_SIZE};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  write.pBufferInfo = &buffer;
  vk.vkUpdateDescriptorSets(context.device(), 1, &write, 0, nullptr);
  DeviceTrace::set_log(set, records_.handle());
}

AccessLog::~AccessLog() {
  const Context& context = machine_->context;
  context.vk().vkDestroyDescriptorPool(context.device(), pool_, nullptr);
  context.vk().vkDestroyDescriptorSetLayout(context.device(), DeviceTrace::log_layout(), nullptr);
  DeviceTrace::set_log(VK_NULL_HANDLE, VK_NULL_HANDLE);
  DeviceTrace::log_accesses(false);
}

void AccessLog::clear() {
  const std::uint32_t head[kFirstAccess] = {kFirstAccess};
  std::memcpy(records_.mapped().data(), head, sizeof head);
  records_.flush();
}

std::vector<AccessTotal> AccessLog::totals(std::size_t dispatch_count) {
  records_.invalidate();
  const std::span<const std::byte> bytes = records_.mapped();
  std::uint32_t end = 0;
  std::memcpy(&end, bytes.data(), sizeof end);
  if (end > bytes.size() / sizeof end)
    throw std::runtime_error("the log of accesses has " + std::to_string(bytes.size()) +
                             " bytes, but " + std::to_string(4ull * end) + " were wanted");
  std::vector<Record> records((end - kFirstAccess) / kAccessWords);
  std::memcpy(records.data(), bytes.data() + kFirstAccess * sizeof end,
              records.size() * sizeof(Record));
  std::ranges::stable_sort(records, {}, &Record::dispatch);
  std::vector<AccessTotal> totals;
  for (std::uint32_t i = 0; i < dispatch_count; ++i) {
    const auto own = std::ranges::equal_range(records, i, {}, &Record::dispatch);
    totals.push_back(total_of(own));
  }
  return totals;
}

}  // namespace planish::bench
