#include "planish/vulkan/device/pipelines.h"

#include <array>
#include <span>

#include "planish/vulkan/device/kernels.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

namespace {

// 0 is the work group's size, which no variant changes.
constexpr std::uint32_t kFirstConstant = 1;

}  // namespace

VkDescriptorType descriptor_type(Binding binding, ReadPath path) {
  return texel_format(binding, path) == VK_FORMAT_UNDEFINED
             ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER
             : VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
}

VkFormat texel_format(Binding binding, ReadPath path) {
  if (path == ReadPath::Storage) return VK_FORMAT_UNDEFINED;
  using enum Binding;
  switch (binding) {
    case Entries:
      return VK_FORMAT_R32G32_UINT;
    case Words:
      return VK_FORMAT_R32_UINT;
    case Records:
      return VK_FORMAT_R32G32B32A32_UINT;
    case Points:
      return VK_FORMAT_R32G32B32A32_SFLOAT;
    case Pairs:
      return VK_FORMAT_R32G32_SFLOAT;
    case Floats:
      return VK_FORMAT_R32_SFLOAT;
    default:
      return VK_FORMAT_UNDEFINED;
  }
}

Pipelines::Pipelines(const DeviceFunctions& functions, VkDevice device, VkPipelineCache cache,
                     const VkAllocationCallbacks* callbacks, const PipelineVariant& variant,
                     const DebugLabels& labels)
    : vk_(functions),
      device_(device),
      cache_(cache),
      callbacks_(callbacks),
      variant_(variant),
      labels_(labels),
      pipelines_(kKernelCount) {
  try {
    for (std::size_t i = 0; i < kKernelCount; ++i) create(static_cast<Kernel>(i));
  } catch (...) {
    destroy();
    throw;
  }
}

Pipelines::~Pipelines() { destroy(); }

void Pipelines::create(Kernel kernel) {
  const KernelSource& source = source_of(kernel);
  Pipeline& target = pipelines_[static_cast<std::size_t>(kernel)];
  target.bindings = std::span(source.bindings).first(source.binding_count);
  target.parameter_bytes = source.parameter_bytes;

  std::array<VkDescriptorSetLayoutBinding, kMaxBindings> bindings{};
  for (std::uint32_t i = 0; i < source.binding_count; ++i)
    bindings[i] = {i, descriptor_type(source.bindings[i], variant_.read_path), 1,
                   VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set_info.bindingCount = source.binding_count;
  set_info.pBindings = bindings.data();
  check(vk_.vkCreateDescriptorSetLayout(device_, &set_info, callbacks_, &target.set_layout),
        "vkCreateDescriptorSetLayout");

  const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, source.parameter_bytes};
  VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout_info.setLayoutCount = 1;
  layout_info.pSetLayouts = &target.set_layout;
  layout_info.pushConstantRangeCount = 1;
  layout_info.pPushConstantRanges = &range;
  check(vk_.vkCreatePipelineLayout(device_, &layout_info, callbacks_, &target.layout),
        "vkCreatePipelineLayout");
}

VkPipeline Pipelines::compile(Kernel kernel, VkPipelineLayout layout,
                              std::span<const std::uint32_t> constants) const {
  const KernelSource& source = source_of(kernel);
  VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  const std::span<const std::uint32_t> code =
      variant_.read_path == ReadPath::Texel ? source.texel : source.storage;
  module_info.codeSize = code.size_bytes();
  module_info.pCode = code.data();
  VkShaderModule module = VK_NULL_HANDLE;
  check(vk_.vkCreateShaderModule(device_, &module_info, callbacks_, &module),
        "vkCreateShaderModule");

  std::vector<std::uint32_t> values = {variant_.chunks_per_group, variant_.lane_sums};
  std::vector<VkSpecializationMapEntry> entries;
  values.insert(values.end(), constants.begin(), constants.end());
  for (std::uint32_t i = 0; i < values.size(); ++i)
    entries.push_back({kFirstConstant + i, i * std::uint32_t{sizeof values[0]}, sizeof values[0]});
  const VkSpecializationInfo info_of_constants{static_cast<std::uint32_t>(entries.size()),
                                               entries.data(), values.size() * sizeof values[0],
                                               values.data()};
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &info_of_constants;
  info.layout = layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  const VkResult result =
      vk_.vkCreateComputePipelines(device_, cache_, 1, &info, callbacks_, &pipeline);
  vk_.vkDestroyShaderModule(device_, module, callbacks_);
  check(result, "vkCreateComputePipelines");
  labels_.name(VK_OBJECT_TYPE_PIPELINE, handle_number(pipeline), source.name);
  return pipeline;
}

void Pipelines::prepare(Kernel kernel) const {
  if (source_of(kernel).is_special) return;
  const std::lock_guard lock(mutex_);
  Pipeline& target = pipelines_[static_cast<std::size_t>(kernel)];
  if (!target.pipeline) target.pipeline = compile(kernel, target.layout, {});
}

Pipeline Pipelines::specialised(Kernel kernel, std::span<const std::uint32_t> constants) const {
  Pipeline result = (*this)[kernel];
  const std::lock_guard lock(mutex_);
  VkPipeline& pipeline = specialised_[{kernel, {constants.begin(), constants.end()}}];
  if (!pipeline) pipeline = compile(kernel, result.layout, constants);
  result.pipeline = pipeline;
  return result;
}

void Pipelines::destroy() noexcept {
  for (const auto& [key, pipeline] : specialised_)
    vk_.vkDestroyPipeline(device_, pipeline, callbacks_);
  for (const Pipeline& kernel : pipelines_) {
    vk_.vkDestroyPipeline(device_, kernel.pipeline, callbacks_);
    vk_.vkDestroyPipelineLayout(device_, kernel.layout, callbacks_);
    vk_.vkDestroyDescriptorSetLayout(device_, kernel.set_layout, callbacks_);
  }
}

}  // namespace planish::vulkan
