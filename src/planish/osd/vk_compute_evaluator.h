#pragma once

#include <opensubdiv/osd/bufferDescriptor.h>

#include <array>

#include "planish/osd/vk_device_context.h"
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
class VkComputeEvaluator {
 public:
  using BufferDescriptor = OpenSubdiv::Osd::BufferDescriptor;
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
    return evalStencils(context, bind(srcBuffer, srcDesc, context),
                        {bind(dstBuffer, dstDesc, context)}, stencilTable);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER>
  static bool EvalStencils(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                           DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                           DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                           DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc,
                           VkStencilTable const* stencilTable, VkComputeEvaluator const* instance,
                           VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalStencils(context, bind(srcBuffer, srcDesc, context),
                        {bind(dstBuffer, dstDesc, context), bind(duBuffer, duDesc, context),
                         bind(dvBuffer, dvDesc, context)},
                        stencilTable);
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
    return evalStencils(context, bind(srcBuffer, srcDesc, context),
                        {bind(dstBuffer, dstDesc, context), bind(duBuffer, duDesc, context),
                         bind(dvBuffer, dvDesc, context), bind(duuBuffer, duuDesc, context),
                         bind(duvBuffer, duvDesc, context), bind(dvvBuffer, dvvDesc, context)},
                        stencilTable);
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

  /// By handles, stencils [start, end) only: stencil i still goes to element i.
  bool EvalStencils(VkBuffer srcBuffer, BufferDescriptor const& srcDesc, VkBuffer dstBuffer,
                    BufferDescriptor const& dstDesc, VkStencilTable const* stencilTable, int start,
                    int end) const;
  bool EvalStencils(VkBuffer srcBuffer, BufferDescriptor const& srcDesc, VkBuffer dstBuffer,
                    BufferDescriptor const& dstDesc, VkBuffer duBuffer,
                    BufferDescriptor const& duDesc, VkBuffer dvBuffer,
                    BufferDescriptor const& dvDesc, VkStencilTable const* stencilTable, int start,
                    int end) const;
  bool EvalStencils(VkBuffer srcBuffer, BufferDescriptor const& srcDesc, VkBuffer dstBuffer,
                    BufferDescriptor const& dstDesc, VkBuffer duBuffer,
                    BufferDescriptor const& duDesc, VkBuffer dvBuffer,
                    BufferDescriptor const& dvDesc, VkBuffer duuBuffer,
                    BufferDescriptor const& duuDesc, VkBuffer duvBuffer,
                    BufferDescriptor const& duvDesc, VkBuffer dvvBuffer,
                    BufferDescriptor const& dvvDesc, VkStencilTable const* stencilTable, int start,
                    int end) const;

 private:
  struct Bound {
    VkBuffer buffer = VK_NULL_HANDLE;
    BufferDescriptor desc;
  };
  /// Destinations in the order of StencilWeights.
  using Destinations = std::array<Bound, kStencilWeightsCount>;

  explicit VkComputeEvaluator(VkDeviceContext* deviceContext) : _deviceContext(deviceContext) {}

  static VkDeviceContext* pick(VkComputeEvaluator const* instance, VkDeviceContext* deviceContext) {
    return deviceContext || !instance ? deviceContext : instance->_deviceContext;
  }

  template <typename BUFFER>
  static Bound bind(BUFFER* buffer, BufferDescriptor const& desc, VkDeviceContext* deviceContext) {
    return {buffer ? buffer->BindVBO(deviceContext) : VK_NULL_HANDLE, desc};
  }

  static bool evalStencils(VkDeviceContext* deviceContext, Bound const& src,
                           Destinations const& destinations, VkStencilTable const* stencilTable);
  static bool evalStencils(VkDeviceContext* deviceContext, Bound const& src,
                           Destinations const& destinations, VkStencilTable const* stencilTable,
                           int start, int end);

  VkDeviceContext* _deviceContext;
};

}  // namespace planish::osd
