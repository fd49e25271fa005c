#include "planish/vulkan/pipelines.h"

#include <span>

#include "planish/vulkan/result.h"
#include "shaders/apply_limit.spv.h"
#include "shaders/apply_stencils.spv.h"
#include "shaders/cg_advance.spv.h"
#include "shaders/cg_apply.spv.h"
#include "shaders/cg_turn.spv.h"
#include "shaders/finish_solve.spv.h"
#include "shaders/interpolation_step.spv.h"
#include "shaders/reduce_rms.spv.h"
#include "shaders/reduce_sums.spv.h"
#include "shaders/shared.h"

namespace planish::vulkan {

namespace {

struct KernelSource {
  std::span<const std::uint32_t> code;
  std::uint32_t binding_count;
  std::uint32_t parameter_bytes;
};

// In the order of enum Kernel.
const KernelSource kSources[kKernelCount] = {
    {spirv::interpolation_step, 8, sizeof(shared::TableParameters)},
    {spirv::reduce_rms, 2, sizeof(shared::VectorParameters)},
    {spirv::finish_solve, 2, sizeof(shared::VectorParameters)},
    {spirv::apply_stencils, 4, sizeof(shared::TableParameters)},
    {spirv::apply_limit, 5, sizeof(shared::TableParameters)},
    {spirv::cg_apply, 6, sizeof(shared::TableParameters)},
    {spirv::cg_advance, 6, sizeof(shared::VectorParameters)},
    {spirv::cg_turn, 2, sizeof(shared::VectorParameters)},
    {spirv::reduce_sums, 2, sizeof(shared::VectorParameters)},
};

}  // namespace

Pipelines::Pipelines(const DeviceFunctions& functions, VkDevice device, VkPipelineCache cache,
                     const VkAllocationCallbacks* callbacks, std::uint32_t chunks_per_group)
    : vk_(functions), device_(device), callbacks_(callbacks) {
  try {
    for (std::size_t i = 0; i < kKernelCount; ++i)
      create(static_cast<Kernel>(i), cache, chunks_per_group);
  } catch (...) {
    destroy();
    throw;
  }
}

Pipelines::~Pipelines() { destroy(); }

void Pipelines::create(Kernel kernel, VkPipelineCache cache, std::uint32_t chunks_per_group) {
  const KernelSource& source = kSources[static_cast<std::size_t>(kernel)];
  Pipeline& target = pipelines_[static_cast<std::size_t>(kernel)];
  target.binding_count = source.binding_count;
  target.parameter_bytes = source.parameter_bytes;

  std::array<VkDescriptorSetLayoutBinding, kMaxBindings> bindings{};
  for (std::uint32_t i = 0; i < source.binding_count; ++i)
    bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
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

  VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  module_info.codeSize = source.code.size_bytes();
  module_info.pCode = source.code.data();
  VkShaderModule module = VK_NULL_HANDLE;
  check(vk_.vkCreateShaderModule(device_, &module_info, callbacks_, &module),
        "vkCreateShaderModule");

  const VkSpecializationMapEntry entry{1, 0, sizeof chunks_per_group};
  const VkSpecializationInfo constants{1, &entry, sizeof chunks_per_group, &chunks_per_group};
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &constants;
  info.layout = target.layout;
  const VkResult result =
      vk_.vkCreateComputePipelines(device_, cache, 1, &info, callbacks_, &target.pipeline);
  vk_.vkDestroyShaderModule(device_, module, callbacks_);
  check(result, "vkCreateComputePipelines");
}

void Pipelines::destroy() noexcept {
  for (const Pipeline& kernel : pipelines_) {
    vk_.vkDestroyPipeline(device_, kernel.pipeline, callbacks_);
    vk_.vkDestroyPipelineLayout(device_, kernel.layout, callbacks_);
    vk_.vkDestroyDescriptorSetLayout(device_, kernel.set_layout, callbacks_);
  }
}

}  // namespace planish::vulkan
