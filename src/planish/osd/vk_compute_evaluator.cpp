#include "planish/osd/vk_compute_evaluator.h"

#include <memory>
#include <vector>

#include "planish/osd/evaluator_passes.h"

namespace planish::osd {

VkComputeEvaluator* VkComputeEvaluator::Create(BufferDescriptor const& srcDesc,
                                               BufferDescriptor const& dstDesc,
                                               BufferDescriptor const& duDesc,
                                               BufferDescriptor const& dvDesc,
                                               VkDeviceContext* deviceContext) {
  return Create(srcDesc, dstDesc, duDesc, dvDesc, {}, {}, {}, deviceContext);
}

VkComputeEvaluator* VkComputeEvaluator::Create(
    BufferDescriptor const& srcDesc, BufferDescriptor const& dstDesc,
    BufferDescriptor const& duDesc, BufferDescriptor const& dvDesc, BufferDescriptor const& duuDesc,
    BufferDescriptor const& duvDesc, BufferDescriptor const& dvvDesc,
    VkDeviceContext* deviceContext) {
  if (!fits(srcDesc, srcDesc.length) || !fits(dstDesc, srcDesc.length)) return nullptr;
  for (BufferDescriptor const* desc : {&dstDesc, &duDesc, &dvDesc, &duuDesc, &duvDesc, &dvvDesc}) {
    if (*desc == BufferDescriptor()) continue;
    if (!fits(*desc, srcDesc.length)) return nullptr;
    vulkan::StencilPass::compile(deviceContext->GetContext(), srcDesc.length, srcDesc.stride,
                                 desc->stride);
  }
  return new VkComputeEvaluator(deviceContext);
}

void VkComputeEvaluator::Synchronize(VkDeviceContext* deviceContext) {
  deviceContext->Synchronize();
}

bool VkComputeEvaluator::evalStencils(VkDeviceContext* deviceContext, Bound const& src,
                                      Destinations const& to, VkStencilTable const* stencilTable,
                                      int start, int end) {
  if (!deviceContext || !stencilTable || !fit(src, to)) return false;
  auto const weights = [&](std::size_t i) {
    return stencilTable->GetWeights(static_cast<StencilWeights>(i));
  };
  for (std::size_t i = 0; i < to.size(); ++i)
    if (to[i].buffer && !weights(i)) return false;
  if (end <= start) return true;
  if (start < 0 || end > stencilTable->GetNumStencils()) return false;

  auto const passes = std::make_shared<std::vector<vulkan::StencilPass>>();
  for (std::size_t i = 0; i < to.size(); ++i)
    if (to[i].buffer)
      passes->emplace_back(deviceContext->GetContext(), *weights(i), Elements(src.buffer, src.desc),
                           Elements(to[i].buffer, to[i].desc), vulkan::PassRows{start, end});
  RunPasses(*deviceContext, passes);
  return true;
}

}  // namespace planish::osd
