#pragma once

#include "planish/osd/vk_patch_evaluator.h"
#include "planish/osd/vk_stencil_table.h"

namespace planish::osd {

/// OpenSubdiv's EVALUATOR on a Vulkan device, with the functions of Osd::GLComputeEvaluator, and
/// the results of Osd::CpuEvaluator. Buffers are given as objects with VkBuffer
/// BindVBO(VkDeviceContext
/// *), such as VkVertexBuffer, or as handles; offsets, lengths and strides are in floats. Source
/// and destination may lie in one buffer where their floats are not the same ones. A null buffer
/// among the destinations is left out.
///
/// Functions record or submit as VkDeviceContext says. They return false, having done nothing,
/// where the arguments do not fit: lengths that differ, strides shorter than lengths, weights that
/// the table does not have, ranges outside of it. Whether a buffer is large enough they cannot
/// know. They throw planish::Error where the device fails, or cannot span a binding.
///
/// An instance is a layout whose kernels are compiled, as Osd::EvaluatorCache keeps them. Static
/// functions take one or null; kernels for other layouts are compiled when first used, and kept by
/// the vulkan::Context.
class VkComputeEvaluator : public VkPatchEvaluator {
 public:
  typedef bool Instantiatable;

  /// Null where the descriptors do not fit. The caller owns the result, which uses the context.
  static VkComputeEvaluator* Create(BufferDescriptor const& srcDesc,
                                    BufferDescriptor const& dstDesc, BufferDescriptor const& duDesc,
                                    BufferDescriptor const& dvDesc, VkDeviceContext* deviceContext);
  static VkComputeEvaluator* Create(BufferDescriptor const& srcDesc,
                                    BufferDescriptor const& dstDesc, BufferDescriptor const& duDesc,
                                    BufferDescriptor const& dvDesc, BufferDescriptor const& duuDesc,
                                    BufferDescriptor const& duvDesc,
                                    BufferDescriptor const& dvvDesc,
                                    VkDeviceContext* deviceContext);

  /// Waits for all that was submitted.
  static void Synchronize(VkDeviceContext* deviceContext);

  // Stencils: element i of a destination = stencil i applied to the source.

  template <typename SRC_BUFFER, typename DST_BUFFER>
  static bool EvalStencils(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                           DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                           VkStencilTable const* stencilTable, VkComputeEvaluator const* instance,
                           VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalStencils(context, bind(context, srcBuffer, srcDesc),
                        destinations(context, dstBuffer, dstDesc), stencilTable, 0,
                        stencilTable ? stencilTable->GetNumStencils() : 0);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER>
  static bool EvalStencils(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                           DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                           DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                           DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc,
                           VkStencilTable const* stencilTable, VkComputeEvaluator const* instance,
                           VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalStencils(
        context, bind(context, srcBuffer, srcDesc),
        destinations(context, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc), stencilTable,
        0, stencilTable ? stencilTable->GetNumStencils() : 0);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER>
  static bool EvalStencils(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                           DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                           DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                           DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc,
                           DST_BUFFER* duuBuffer, BufferDescriptor const& duuDesc,
                           DST_BUFFER* duvBuffer, BufferDescriptor const& duvDesc,
                           DST_BUFFER* dvvBuffer, BufferDescriptor const& dvvDesc,
                           VkStencilTable const* stencilTable, VkComputeEvaluator const* instance,
                           VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalStencils(
        context, bind(context, srcBuffer, srcDesc),
        destinations(context, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc, duuBuffer,
                     duuDesc, duvBuffer, duvDesc, dvvBuffer, dvvDesc),
        stencilTable, 0, stencilTable ? stencilTable->GetNumStencils() : 0);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER>
  bool EvalStencils(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc, DST_BUFFER* dstBuffer,
                    BufferDescriptor const& dstDesc, VkStencilTable const* stencilTable) const {
    return EvalStencils(srcBuffer, srcDesc, dstBuffer, dstDesc, stencilTable, this);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER>
  bool EvalStencils(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc, DST_BUFFER* dstBuffer,
                    BufferDescriptor const& dstDesc, DST_BUFFER* duBuffer,
                    BufferDescriptor const& duDesc, DST_BUFFER* dvBuffer,
                    BufferDescriptor const& dvDesc, VkStencilTable const* stencilTable) const {
    return EvalStencils(srcBuffer, srcDesc, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc,
                        stencilTable, this);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER>
  bool EvalStencils(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc, DST_BUFFER* dstBuffer,
                    BufferDescriptor const& dstDesc, DST_BUFFER* duBuffer,
                    BufferDescriptor const& duDesc, DST_BUFFER* dvBuffer,
                    BufferDescriptor const& dvDesc, DST_BUFFER* duuBuffer,
                    BufferDescriptor const& duuDesc, DST_BUFFER* duvBuffer,
                    BufferDescriptor const& duvDesc, DST_BUFFER* dvvBuffer,
                    BufferDescriptor const& dvvDesc, VkStencilTable const* stencilTable) const {
    return EvalStencils(srcBuffer, srcDesc, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc,
                        duuBuffer, duuDesc, duvBuffer, duvDesc, dvvBuffer, dvvDesc, stencilTable,
                        this);
  }

  // By handles, stencils [start, end) only: stencil i still goes to element i.

  bool EvalStencils(VkBuffer srcBuffer, BufferDescriptor const& srcDesc, VkBuffer dstBuffer,
                    BufferDescriptor const& dstDesc, VkStencilTable const* stencilTable, int start,
                    int end) const {
    return evalStencils(_deviceContext, {srcBuffer, srcDesc},
                        destinations(_deviceContext, dstBuffer, dstDesc), stencilTable, start, end);
  }

  bool EvalStencils(VkBuffer srcBuffer, BufferDescriptor const& srcDesc, VkBuffer dstBuffer,
                    BufferDescriptor const& dstDesc, VkBuffer duBuffer,
                    BufferDescriptor const& duDesc, VkBuffer dvBuffer,
                    BufferDescriptor const& dvDesc, VkStencilTable const* stencilTable, int start,
                    int end) const {
    return evalStencils(
        _deviceContext, {srcBuffer, srcDesc},
        destinations(_deviceContext, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc),
        stencilTable, start, end);
  }

  bool EvalStencils(VkBuffer srcBuffer, BufferDescriptor const& srcDesc, VkBuffer dstBuffer,
                    BufferDescriptor const& dstDesc, VkBuffer duBuffer,
                    BufferDescriptor const& duDesc, VkBuffer dvBuffer,
                    BufferDescriptor const& dvDesc, VkBuffer duuBuffer,
                    BufferDescriptor const& duuDesc, VkBuffer duvBuffer,
                    BufferDescriptor const& duvDesc, VkBuffer dvvBuffer,
                    BufferDescriptor const& dvvDesc, VkStencilTable const* stencilTable, int start,
                    int end) const {
    return evalStencils(
        _deviceContext, {srcBuffer, srcDesc},
        destinations(_deviceContext, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc,
                     duuBuffer, duuDesc, duvBuffer, duvDesc, dvvBuffer, dvvDesc),
        stencilTable, start, end);
  }

 private:
  using VkPatchEvaluator::VkPatchEvaluator;

  static bool evalStencils(VkDeviceContext* deviceContext, Bound const& src, Destinations const& to,
                           VkStencilTable const* stencilTable, int start, int end);
};

}  // namespace planish::osd
