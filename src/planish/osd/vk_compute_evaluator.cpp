#include "planish/osd/vk_compute_evaluator.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "planish/vulkan/commands.h"
#include "planish/vulkan/stencil_pass.h"

namespace planish::osd {

namespace {

using OpenSubdiv::Osd::BufferDescriptor;

bool fits(BufferDescriptor const& desc, int length) {
  return length > 0 && desc.length == length && desc.stride >= length && desc.offset >= 0;
}

vulkan::FloatElements elements(VkBuffer buffer, BufferDescriptor const& desc) {
  return {buffer, static_cast<std::uint64_t>(desc.offset), static_cast<std::uint32_t>(desc.length),
          static_cast<std::uint32_t>(desc.stride)};
}

}  // namespace

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
                                      Destinations const& destinations,
                                      VkStencilTable const* stencilTable) {
  return stencilTable && evalStencils(deviceContext, src, destinations, stencilTable, 0,
                                      stencilTable->GetNumStencils());
}

bool VkComputeEvaluator::evalStencils(VkDeviceContext* deviceContext, Bound const& src,
                                      Destinations const& destinations,
                                      VkStencilTable const* stencilTable, int start, int end) {
  if (!deviceContext || !stencilTable || !src.buffer) return false;
  if (!fits(src.desc, src.desc.length)) return false;
  for (int i = 0; i < kStencilWeightsCount; ++i) {
    if (!destinations[i].buffer) continue;
    if (!fits(destinations[i].desc, src.desc.length)) return false;
    if (!stencilTable->GetWeights(static_cast<StencilWeights>(i))) return false;
  }
  if (end <= start) return true;
  if (start < 0 || end > stencilTable->GetNumStencils()) return false;

  vulkan::Context& context = deviceContext->GetContext();
  auto const passes = std::make_shared<std::vector<vulkan::StencilPass>>();
  for (int i = 0; i < kStencilWeightsCount; ++i)
    if (destinations[i].buffer)
      passes->emplace_back(context, *stencilTable->GetWeights(static_cast<StencilWeights>(i)),
                           elements(src.buffer, src.desc),
                           elements(destinations[i].buffer, destinations[i].desc),
                           vulkan::RowRange{start, end});
  auto const record = [&](VkCommandBuffer commands) {
    for (vulkan::StencilPass const& pass : *passes) {
      // Destinations may interleave in one buffer.
      if (&pass != passes->data())
        vulkan::record_barrier(context, commands, vulkan::kKernelScope, vulkan::kKernelScope);
      pass.record(commands);
    }
  };
  deviceContext->Run(record, passes);
  return true;
}

bool VkComputeEvaluator::EvalStencils(VkBuffer srcBuffer, BufferDescriptor const& srcDesc,
                                      VkBuffer dstBuffer, BufferDescriptor const& dstDesc,
                                      VkStencilTable const* stencilTable, int start,
                                      int end) const {
  return evalStencils(_deviceContext, {srcBuffer, srcDesc}, {Bound{dstBuffer, dstDesc}},
                      stencilTable, start, end);
}

bool VkComputeEvaluator::EvalStencils(VkBuffer srcBuffer, BufferDescriptor const& srcDesc,
                                      VkBuffer dstBuffer, BufferDescriptor const& dstDesc,
                                      VkBuffer duBuffer, BufferDescriptor const& duDesc,
                                      VkBuffer dvBuffer, BufferDescriptor const& dvDesc,
                                      VkStencilTable const* stencilTable, int start,
                                      int end) const {
  return evalStencils(_deviceContext, {srcBuffer, srcDesc},
                      {Bound{dstBuffer, dstDesc}, Bound{duBuffer, duDesc}, Bound{dvBuffer, dvDesc}},
                      stencilTable, start, end);
}

bool VkComputeEvaluator::EvalStencils(VkBuffer srcBuffer, BufferDescriptor const& srcDesc,
                                      VkBuffer dstBuffer, BufferDescriptor const& dstDesc,
                                      VkBuffer duBuffer, BufferDescriptor const& duDesc,
                                      VkBuffer dvBuffer, BufferDescriptor const& dvDesc,
                                      VkBuffer duuBuffer, BufferDescriptor const& duuDesc,
                                      VkBuffer duvBuffer, BufferDescriptor const& duvDesc,
                                      VkBuffer dvvBuffer, BufferDescriptor const& dvvDesc,
                                      VkStencilTable const* stencilTable, int start,
                                      int end) const {
  return evalStencils(
      _deviceContext, {srcBuffer, srcDesc},
      {Bound{dstBuffer, dstDesc}, Bound{duBuffer, duDesc}, Bound{dvBuffer, dvDesc},
       Bound{duuBuffer, duuDesc}, Bound{duvBuffer, duvDesc}, Bound{dvvBuffer, dvvDesc}},
      stencilTable, start, end);
}

}  // namespace planish::osd
