#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>

#include "bench/benchmarks.h"
#include "bench/copy_vectors.spv.h"
#include "bench/traced_device.h"
#include "planish/core/error.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/driver.h"

namespace planish::bench {
namespace {

// Two buffers on a device, and the two ways to copy one to the other: what the kernels' speeds are
// measured against. The machine outlives it.
class DeviceCopy {
 public:
  // Buffers of `bytes`, or of what a binding and an eighth of the device's memory hold.
  DeviceCopy(vulkan::VulkanMachine& machine, std::uint64_t bytes);
  ~DeviceCopy();
  DeviceCopy(const DeviceCopy&) = delete;
  DeviceCopy& operator=(const DeviceCopy&) = delete;

  // Bytes of each buffer; a copy reads as many and writes as many.
  [[nodiscard]] std::uint64_t bytes() const { return source_.size(); }
  void record_kernel(VkCommandBuffer commands) const;
  void record_command(VkCommandBuffer commands) const;
  // Whether the target holds what the source does; fills the target with something else.
  [[nodiscard]] bool has_copied();

 private:
  void make_pipeline();
  void make_set();
  void destroy() noexcept;

  vulkan::VulkanMachine& machine_;
  vulkan::Buffer source_, target_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

constexpr std::uint32_t kCopyLanes = 64;
constexpr std::uint64_t kVectorBytes = 16;

std::uint64_t fitting_bytes(const vulkan::Context& context, std::uint64_t bytes) {
  const std::uint64_t heap = context.capabilities().largest_device_heap / 8;
  const std::uint64_t most = std::min({bytes, context.max_storage_range(), heap});
  return std::max(most / kVectorBytes, std::uint64_t(kCopyLanes)) * kVectorBytes;
}

DeviceCopy::DeviceCopy(vulkan::VulkanMachine& machine, std::uint64_t bytes)
    : machine_(machine),
      source_(machine.context, fitting_bytes(machine.context, bytes), vulkan::MemoryUse::Device),
      target_(machine.context, source_.size(), vulkan::MemoryUse::Device) {
  try {
    make_pipeline();
    make_set();
  } catch (...) {
    destroy();
    throw;
  }
  machine.submitter.run([&](VkCommandBuffer commands) {
    const vulkan::DeviceFunctions& vk = machine_.context.vk();
    vk.vkCmdFillBuffer(commands, source_.handle(), 0, VK_WHOLE_SIZE, 0x3f800000);
    vk.vkCmdFillBuffer(commands, target_.handle(), 0, VK_WHOLE_SIZE, 0);
  });
}

void DeviceCopy::make_pipeline() {
  const vulkan::DeviceFunctions& vk = machine_.context.vk();
  const VkDevice device = machine_.context.device();
  std::array<VkDescriptorSetLayoutBinding, 2> bindings{};
  for (std::uint32_t i = 0; i < bindings.size(); ++i)
    bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set_info.bindingCount = static_cast<std::uint32_t>(bindings.size());
  set_info.pBindings = bindings.data();
  vulkan::check(vk.vkCreateDescriptorSetLayout(device, &set_info, nullptr, &set_layout_),
                "vkCreateDescriptorSetLayout");
  const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(std::uint32_t)};
  VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout_info.setLayoutCount = 1;
  layout_info.pSetLayouts = &set_layout_;
  layout_info.pushConstantRangeCount = 1;
  layout_info.pPushConstantRanges = &range;
  vulkan::check(vk.vkCreatePipelineLayout(device, &layout_info, nullptr, &layout_),
                "vkCreatePipelineLayout");
  const std::span<const std::uint32_t> code = spirv::copy_vectors;
  VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  module_info.codeSize = code.size_bytes();
  module_info.pCode = code.data();
  VkShaderModule module = VK_NULL_HANDLE;
  vulkan::check(vk.vkCreateShaderModule(device, &module_info, nullptr, &module),
                "vkCreateShaderModule");
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.layout = layout_;
  const VkResult result =
      vk.vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_);
  vk.vkDestroyShaderModule(device, module, nullptr);
  vulkan::check(result, "vkCreateComputePipelines");
}

void DeviceCopy::make_set() {
  const vulkan::DeviceFunctions& vk = machine_.context.vk();
  const VkDevice device = machine_.context.device();
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2};
  VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool_info.maxSets = 1;
  pool_info.poolSizeCount = 1;
  pool_info.pPoolSizes = &size;
  vulkan::check(vk.vkCreateDescriptorPool(device, &pool_info, nullptr, &pool_),
                "vkCreateDescriptorPool");
  VkDescriptorSetAllocateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  set_info.descriptorPool = pool_;
  set_info.descriptorSetCount = 1;
  set_info.pSetLayouts = &set_layout_;
  vulkan::check(vk.vkAllocateDescriptorSets(device, &set_info, &set_), "vkAllocateDescriptorSets");
  const std::array<VkDescriptorBufferInfo, 2> buffers = {
      VkDescriptorBufferInfo{source_.handle(), 0, source_.size()},
      VkDescriptorBufferInfo{target_.handle(), 0, target_.size()}};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set_;
  write.descriptorCount = static_cast<std::uint32_t>(buffers.size());
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  write.pBufferInfo = buffers.data();
  vk.vkUpdateDescriptorSets(device, 1, &write, 0, nullptr);
}

DeviceCopy::~DeviceCopy() { destroy(); }

void DeviceCopy::destroy() noexcept {
  const vulkan::DeviceFunctions& vk = machine_.context.vk();
  const VkDevice device = machine_.context.device();
  vk.vkDestroyDescriptorPool(device, pool_, nullptr);
  vk.vkDestroyPipeline(device, pipeline_, nullptr);
  vk.vkDestroyPipelineLayout(device, layout_, nullptr);
  vk.vkDestroyDescriptorSetLayout(device, set_layout_, nullptr);
}

void DeviceCopy::record_kernel(VkCommandBuffer commands) const {
  const vulkan::DeviceFunctions& vk = machine_.context.vk();
  const auto count = static_cast<std::uint32_t>(bytes() / kVectorBytes);
  const std::uint32_t groups =
      std::min((count + kCopyLanes - 1) / kCopyLanes, machine_.context.max_group_count());
  vk.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
  vk.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0,
                             nullptr);
  vk.vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof count, &count);
  vk.vkCmdDispatch(commands, groups, 1, 1);
}

void DeviceCopy::record_command(VkCommandBuffer commands) const {
  const VkBufferCopy region{0, 0, bytes()};
  machine_.context.vk().vkCmdCopyBuffer(commands, source_.handle(), target_.handle(), 1, &region);
}

bool DeviceCopy::has_copied() {
  bool same = true;
  machine_.submitter.download(whole(target_), [&](std::uint64_t, std::span<const std::byte> piece) {
    for (std::size_t at = 0; at + 4 <= piece.size(); at += 4) {
      std::uint32_t word = 0;
      std::memcpy(&word, &piece[at], sizeof word);
      same = same && word == 0x3f800000;
    }
  });
  machine_.submitter.run([&](VkCommandBuffer commands) {
    machine_.context.vk().vkCmdFillBuffer(commands, target_.handle(), 0, VK_WHOLE_SIZE, 0);
  });
  return same;
}

// How fast the kernels of a frame are beside a copy of memory: bytes by the ranges that they bind,
// times by the device's own clock, all in one submission.

using namespace vulkan;

// Iterations in the submission; one step more measures.
constexpr std::uint32_t kTimedIterations = 4;
constexpr std::uint32_t kCopySpans = 2;
constexpr std::uint64_t kSoftwareCopyBytes = 64u << 20;  // caches hold less, and it takes longer

// What the dispatches of one kernel come to.
struct KernelTotal {
  std::string name;
  std::uint64_t dispatches = 0, indirect = 0;
  std::uint64_t barriers = 0;    // behind its dispatches
  std::uint64_t bytes = 0;       // of the others: how often the device runs those is its own affair
  std::vector<double> times_ms;  // per repetition
};

void record_frame(const DeviceFrame& frame, VkCommandBuffer commands) {
  frame.solve.record_solve(commands, {.iterations = kTimedIterations, .measures_last = true});
  frame.solve.record_evaluate(commands);
}

// What one pass of the kernel makes, times its passes.
double elements_of(std::string_view kernel, const PolygonMesh& mesh, const DeviceFrame& frame) {
  if (kernel == "first_step") return static_cast<double>(mesh.face_vertices.size());
  if (kernel == "corner_patches") return frame.system.vertex_count();
  const double passes = kernel == "interpolation_step" ? kTimedIterations + 1 : 1;
  return passes * mesh.vertex_count();
}

class FrameKernels {
 public:
  FrameKernels(VulkanMachine& machine, DeviceCopy& copy, const PolygonMesh& mesh,
               InterpolationMethod method, const std::string& what)
      : machine_(machine),
        copy_(copy),
        mesh_(mesh),
        frame_(machine, mesh, {.level = kFrameLevel, .method = method}) {
    group_.name = "kernels";
    group_.size = formatted("{}, {}{} vertices; {}", what,
                            method == InterpolationMethod::Fair ? "fair, " : "progressive, ",
                            frame_.system.vertex_count(), machine.device.capabilities().name);
    group_.baseline = "vkCmdCopyBuffer";
  }

  std::vector<Row> measure(int repetitions) {
    std::vector<TracedDispatch> dispatches;
    machine_.submitter.run([&](VkCommandBuffer commands) {
      DeviceTrace::begin({});
      record_frame(frame_, commands);
      dispatches = DeviceTrace::end();
    });
    const auto count = static_cast<std::uint32_t>(dispatches.size());
    const DeviceClock clock(machine_, 2 * (kCopySpans + count));
    std::vector<KernelTotal> totals = totals_of(dispatches);
    for (int i = 0; i < repetitions; ++i) run_once(clock, dispatches, totals);
    if (!copy_.has_copied()) throw std::runtime_error("a copy left something out");
    return rows_of(totals);
  }

 private:
  [[nodiscard]] std::vector<KernelTotal> totals_of(
      const std::vector<TracedDispatch>& dispatches) const {
    std::vector<KernelTotal> totals = {{"copy-kernel", 1}, {"vkCmdCopyBuffer", 1}};
    for (KernelTotal& total : totals) total.bytes = 2 * copy_.bytes();
    for (const TracedDispatch& dispatch : dispatches) {
      KernelTotal& total = total_of(totals, dispatch);
      ++(dispatch.is_indirect ? total.indirect : total.dispatches);
      total.barriers += dispatch.barriers;
      if (!dispatch.is_indirect) total.bytes += dispatch.bound_bytes;
    }
    return totals;
  }

  KernelTotal& total_of(std::vector<KernelTotal>& totals, const TracedDispatch& dispatch) const {
    const std::string_view name = kernel_of(machine_.context, dispatch.layout);
    const auto found = std::find_if(totals.begin(), totals.end(),
                                    [&](const KernelTotal& total) { return total.name == name; });
    if (found != totals.end()) return *found;
    return totals.emplace_back(KernelTotal{std::string(name)});
  }

  void run_once(const DeviceClock& clock, const std::vector<TracedDispatch>& dispatches,
                std::vector<KernelTotal>& totals) {
    machine_.submitter.run([&](VkCommandBuffer commands) {
      const auto barrier = [&] {
        record_barrier(machine_.context, commands, kExitScope, kEntryScope);
      };
      clock.record_reset(commands);
      clock.record(commands, 0);
      copy_.record_kernel(commands);
      clock.record(commands, 1);
      barrier();
      clock.record(commands, 2);
      copy_.record_command(commands);
      clock.record(commands, 3);
      barrier();
      DeviceTrace::begin({clock.pool(), 2 * kCopySpans});
      record_frame(frame_, commands);
      (void)DeviceTrace::end();
    });
    const auto count = static_cast<std::uint32_t>(dispatches.size());
    const std::vector<double> spans = clock.spans(0, kCopySpans + count);
    if (spans.empty()) return;
    for (KernelTotal& total : totals) total.times_ms.push_back(0);
    for (std::size_t i = 0; i < spans.size(); ++i) {
      KernelTotal& total =
          i < kCopySpans ? totals[i] : total_of(totals, dispatches[i - kCopySpans]);
      total.times_ms.back() += spans[i];
    }
  }

  [[nodiscard]] std::vector<Row> rows_of(std::vector<KernelTotal>& totals) const {
    KernelTotal all{"frame"};
    for (std::size_t i = kCopySpans; i < totals.size(); ++i) {
      all.dispatches += totals[i].dispatches;
      all.indirect += totals[i].indirect;
      all.barriers += totals[i].barriers;
      all.bytes += totals[i].bytes;
      all.times_ms.resize(totals[i].times_ms.size());
      for (std::size_t k = 0; k < all.times_ms.size(); ++k)
        all.times_ms[k] += totals[i].times_ms[k];
    }
    totals.push_back(all);
    std::vector<Row> rows;
    double copy_speed = 0;  // of the faster one
    for (const KernelTotal& total : totals) {
      Row row = row_of_times(group_, total.name, total.times_ms);
      const double elements = rows.size() < kCopySpans ? static_cast<double>(copy_.bytes()) / 16
                                                       : elements_of(total.name, mesh_, frame_);
      row.figures = {{"dispatches", static_cast<double>(total.dispatches)},
                     {"indirect_dispatches", static_cast<double>(total.indirect)},
                     {"barriers", static_cast<double>(total.barriers)},
                     {"bytes", static_cast<double>(total.bytes)},
                     {"elements", elements},
                     {"bytes_per_element", static_cast<double>(total.bytes) / elements}};
      // Where the device decides how often a kernel runs, bytes tell nothing of its speed.
      if (row.median_ms > 0 && total.indirect == 0) {
        const double speed = 1e-6 * static_cast<double>(total.bytes) / row.median_ms;
        if (rows.size() < kCopySpans) copy_speed = std::max(copy_speed, speed);
        row.figures.emplace_back("gigabytes_per_second", speed);
        if (rows.size() >= kCopySpans) row.figures.emplace_back("copy_share", speed / copy_speed);
      }
      rows.push_back(row);
    }
    for (Row& row : rows) row.ratio = rows[1].median_ms > 0 ? row.median_ms / rows[1].median_ms : 0;
    return rows;
  }

  VulkanMachine& machine_;
  DeviceCopy& copy_;
  const PolygonMesh& mesh_;
  DeviceFrame frame_;
  Group group_;
};

}  // namespace

std::vector<Row> bench_kernels(const Options& options) {
  const auto machine = traced_machine(options);
  if (!machine) return {};
  const bool is_software = machine->device.capabilities().kind == "software";
  DeviceCopy copy(*machine, is_software ? std::min(options.copy_bytes, kSoftwareCopyBytes)
                                        : options.copy_bytes);
  std::vector<Row> rows;
  const auto measure = [&](const PolygonMesh& mesh, InterpolationMethod method,
                           const std::string& what) {
    try {
      FrameKernels kernels(*machine, copy, mesh, method, what);
      const std::vector<Row> measured = kernels.measure(options.repetitions);
      rows.insert(rows.end(), measured.begin(), measured.end());
    } catch (const Error& error) {
      const bool is_fair = method == InterpolationMethod::Fair;
      rows.push_back(refusal(error, "kernels", what, is_fair ? "fair" : "progressive"));
    }
  };
  for (const std::int32_t point_count : options.point_counts) {
    const PolygonMesh mesh = rough_torus(point_count);
    for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair})
      measure(mesh, method, formatted("{} points", mesh.vertex_count()));
  }
  measure(uneven_bipyramid(options.hub_faces), InterpolationMethod::Fair,
          formatted("hubs of {}", options.hub_faces));
  return rows;
}

}  // namespace planish::bench
