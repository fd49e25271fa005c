#pragma once

#include <opensubdiv/osd/bufferDescriptor.h>

#include <vector>

#include "planish/osd/vk_device_context.h"
#include "planish/osd/vk_patch_table.h"

namespace planish::osd {

/// What all functions of an evaluator share.
class VkEvaluator {
 public:
  using BufferDescriptor = OpenSubdiv::Osd::BufferDescriptor;

 protected:
  struct Bound {
    VkBuffer buffer = VK_NULL_HANDLE;
    BufferDescriptor desc;
  };
  /// Value, du, dv, duu, duv, dvv, or the first ones of them.
  using Destinations = std::vector<Bound>;

  explicit VkEvaluator(VkDeviceContext* deviceContext) : _deviceContext(deviceContext) {}

  static VkDeviceContext* pick(VkEvaluator const* instance, VkDeviceContext* deviceContext) {
    return deviceContext || !instance ? deviceContext : instance->_deviceContext;
  }

  template <typename BUFFER>
  static Bound bind(VkDeviceContext* deviceContext, BUFFER* buffer, BufferDescriptor const& desc) {
    return {buffer ? buffer->BindVBO(deviceContext) : VK_NULL_HANDLE, desc};
  }
  static Bound bind(VkDeviceContext*, VkBuffer buffer, BufferDescriptor const& desc) {
    return {buffer, desc};
  }

  /// Of a buffer and its descriptor, another and its descriptor, ...
  template <typename BUFFER, typename... MORE>
  static Destinations destinations(VkDeviceContext* deviceContext, BUFFER buffer,
                                   BufferDescriptor const& desc, MORE const&... more) {
    Destinations result;
    if constexpr (sizeof...(more) > 0) result = destinations(deviceContext, more...);
    result.insert(result.begin(), bind(deviceContext, buffer, desc));
    return result;
  }

  /// Whether length floats of every element lie apart from the next element.
  static bool fits(BufferDescriptor const& desc, int length);
  /// Whether there is a source, and all destinations that there are have its length.
  static bool fit(Bound const& src, Destinations const& to);

  VkDeviceContext* _deviceContext;
};

/// The part of VkComputeEvaluator that evaluates patches: element i of a destination = the patch at
/// coordinate i, or a derivative of it by the coordinate. Coordinates are Osd::PatchCoord in a
/// buffer of 5 floats each, such as a VkVertexBuffer. Points come from the source: control
/// vertices, refined vertices, and the patch table's own points after them. Zero for Far's legacy
/// Gregory patches, as from Osd::CpuEvaluator.
class VkPatchEvaluator : public VkEvaluator {
 public:
  // Vertex data.

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  static bool EvalPatches(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                          DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                          int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                          VkPatchTable const* patchTable, VkPatchEvaluator const* instance,
                          VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalPatches(context, bind(context, srcBuffer, srcDesc),
                       destinations(context, dstBuffer, dstDesc), numPatchCoords,
                       bind(context, patchCoords, {}).buffer,
                       patchTable ? patchTable->GetPatches() : nullptr);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  static bool EvalPatches(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                          DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                          DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                          DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc, int numPatchCoords,
                          PATCHCOORD_BUFFER* patchCoords, VkPatchTable const* patchTable,
                          VkPatchEvaluator const* instance,
                          VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalPatches(
        context, bind(context, srcBuffer, srcDesc),
        destinations(context, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc),
        numPatchCoords, bind(context, patchCoords, {}).buffer,
        patchTable ? patchTable->GetPatches() : nullptr);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  static bool EvalPatches(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                          DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                          DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                          DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc,
                          DST_BUFFER* duuBuffer, BufferDescriptor const& duuDesc,
                          DST_BUFFER* duvBuffer, BufferDescriptor const& duvDesc,
                          DST_BUFFER* dvvBuffer, BufferDescriptor const& dvvDesc,
                          int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                          VkPatchTable const* patchTable, VkPatchEvaluator const* instance,
                          VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalPatches(context, bind(context, srcBuffer, srcDesc),
                       destinations(context, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc,
                                    duuBuffer, duuDesc, duvBuffer, duvDesc, dvvBuffer, dvvDesc),
                       numPatchCoords, bind(context, patchCoords, {}).buffer,
                       patchTable ? patchTable->GetPatches() : nullptr);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  bool EvalPatches(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc, DST_BUFFER* dstBuffer,
                   BufferDescriptor const& dstDesc, int numPatchCoords,
                   PATCHCOORD_BUFFER* patchCoords, VkPatchTable const* patchTable) const {
    return EvalPatches(srcBuffer, srcDesc, dstBuffer, dstDesc, numPatchCoords, patchCoords,
                       patchTable, this);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  bool EvalPatches(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc, DST_BUFFER* dstBuffer,
                   BufferDescriptor const& dstDesc, DST_BUFFER* duBuffer,
                   BufferDescriptor const& duDesc, DST_BUFFER* dvBuffer,
                   BufferDescriptor const& dvDesc, int numPatchCoords,
                   PATCHCOORD_BUFFER* patchCoords, VkPatchTable const* patchTable) const {
    return EvalPatches(srcBuffer, srcDesc, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc,
                       numPatchCoords, patchCoords, patchTable, this);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  bool EvalPatches(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc, DST_BUFFER* dstBuffer,
                   BufferDescriptor const& dstDesc, DST_BUFFER* duBuffer,
                   BufferDescriptor const& duDesc, DST_BUFFER* dvBuffer,
                   BufferDescriptor const& dvDesc, DST_BUFFER* duuBuffer,
                   BufferDescriptor const& duuDesc, DST_BUFFER* duvBuffer,
                   BufferDescriptor const& duvDesc, DST_BUFFER* dvvBuffer,
                   BufferDescriptor const& dvvDesc, int numPatchCoords,
                   PATCHCOORD_BUFFER* patchCoords, VkPatchTable const* patchTable) const {
    return EvalPatches(srcBuffer, srcDesc, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc,
                       duuBuffer, duuDesc, duvBuffer, duvDesc, dvvBuffer, dvvDesc, numPatchCoords,
                       patchCoords, patchTable, this);
  }

  // Varying data: linear on every patch. False where the table has no varying patches.

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  static bool EvalPatchesVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                                 DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                                 int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                                 VkPatchTable const* patchTable, VkPatchEvaluator const* instance,
                                 VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalPatches(context, bind(context, srcBuffer, srcDesc),
                       destinations(context, dstBuffer, dstDesc), numPatchCoords,
                       bind(context, patchCoords, {}).buffer,
                       patchTable ? patchTable->GetVaryingPatches() : nullptr);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  static bool EvalPatchesVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                                 DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                                 DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                                 DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc,
                                 int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                                 VkPatchTable const* patchTable, VkPatchEvaluator const* instance,
                                 VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalPatches(
        context, bind(context, srcBuffer, srcDesc),
        destinations(context, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc),
        numPatchCoords, bind(context, patchCoords, {}).buffer,
        patchTable ? patchTable->GetVaryingPatches() : nullptr);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  static bool EvalPatchesVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                                 DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                                 DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                                 DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc,
                                 DST_BUFFER* duuBuffer, BufferDescriptor const& duuDesc,
                                 DST_BUFFER* duvBuffer, BufferDescriptor const& duvDesc,
                                 DST_BUFFER* dvvBuffer, BufferDescriptor const& dvvDesc,
                                 int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                                 VkPatchTable const* patchTable, VkPatchEvaluator const* instance,
                                 VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalPatches(context, bind(context, srcBuffer, srcDesc),
                       destinations(context, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc,
                                    duuBuffer, duuDesc, duvBuffer, duvDesc, dvvBuffer, dvvDesc),
                       numPatchCoords, bind(context, patchCoords, {}).buffer,
                       patchTable ? patchTable->GetVaryingPatches() : nullptr);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  bool EvalPatchesVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                          DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                          int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                          VkPatchTable const* patchTable) const {
    return EvalPatchesVarying(srcBuffer, srcDesc, dstBuffer, dstDesc, numPatchCoords, patchCoords,
                              patchTable, this);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  bool EvalPatchesVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                          DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                          DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                          DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc, int numPatchCoords,
                          PATCHCOORD_BUFFER* patchCoords, VkPatchTable const* patchTable) const {
    return EvalPatchesVarying(srcBuffer, srcDesc, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer,
                              dvDesc, numPatchCoords, patchCoords, patchTable, this);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  bool EvalPatchesVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                          DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                          DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                          DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc,
                          DST_BUFFER* duuBuffer, BufferDescriptor const& duuDesc,
                          DST_BUFFER* duvBuffer, BufferDescriptor const& duvDesc,
                          DST_BUFFER* dvvBuffer, BufferDescriptor const& dvvDesc,
                          int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                          VkPatchTable const* patchTable) const {
    return EvalPatchesVarying(srcBuffer, srcDesc, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer,
                              dvDesc, duuBuffer, duuDesc, duvBuffer, duvDesc, dvvBuffer, dvvDesc,
                              numPatchCoords, patchCoords, patchTable, this);
  }

  // A channel of face-varying data. False where the table has no such channel.

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  static bool EvalPatchesFaceVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                                     DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                                     int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                                     VkPatchTable const* patchTable, int fvarChannel,
                                     VkPatchEvaluator const* instance,
                                     VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalPatches(context, bind(context, srcBuffer, srcDesc),
                       destinations(context, dstBuffer, dstDesc), numPatchCoords,
                       bind(context, patchCoords, {}).buffer,
                       patchTable ? patchTable->GetFVarPatches(fvarChannel) : nullptr);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  static bool EvalPatchesFaceVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                                     DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                                     DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                                     DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc,
                                     int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                                     VkPatchTable const* patchTable, int fvarChannel,
                                     VkPatchEvaluator const* instance,
                                     VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalPatches(
        context, bind(context, srcBuffer, srcDesc),
        destinations(context, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc),
        numPatchCoords, bind(context, patchCoords, {}).buffer,
        patchTable ? patchTable->GetFVarPatches(fvarChannel) : nullptr);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  static bool EvalPatchesFaceVarying(
      SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc, DST_BUFFER* dstBuffer,
      BufferDescriptor const& dstDesc, DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
      DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc, DST_BUFFER* duuBuffer,
      BufferDescriptor const& duuDesc, DST_BUFFER* duvBuffer, BufferDescriptor const& duvDesc,
      DST_BUFFER* dvvBuffer, BufferDescriptor const& dvvDesc, int numPatchCoords,
      PATCHCOORD_BUFFER* patchCoords, VkPatchTable const* patchTable, int fvarChannel,
      VkPatchEvaluator const* instance, VkDeviceContext* deviceContext = nullptr) {
    VkDeviceContext* const context = pick(instance, deviceContext);
    return evalPatches(context, bind(context, srcBuffer, srcDesc),
                       destinations(context, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc,
                                    duuBuffer, duuDesc, duvBuffer, duvDesc, dvvBuffer, dvvDesc),
                       numPatchCoords, bind(context, patchCoords, {}).buffer,
                       patchTable ? patchTable->GetFVarPatches(fvarChannel) : nullptr);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  bool EvalPatchesFaceVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                              DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                              int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                              VkPatchTable const* patchTable, int fvarChannel = 0) const {
    return EvalPatchesFaceVarying(srcBuffer, srcDesc, dstBuffer, dstDesc, numPatchCoords,
                                  patchCoords, patchTable, fvarChannel, this);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  bool EvalPatchesFaceVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                              DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                              DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                              DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc,
                              int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                              VkPatchTable const* patchTable, int fvarChannel = 0) const {
    return EvalPatchesFaceVarying(srcBuffer, srcDesc, dstBuffer, dstDesc, duBuffer, duDesc,
                                  dvBuffer, dvDesc, numPatchCoords, patchCoords, patchTable,
                                  fvarChannel, this);
  }

  template <typename SRC_BUFFER, typename DST_BUFFER, typename PATCHCOORD_BUFFER>
  bool EvalPatchesFaceVarying(SRC_BUFFER* srcBuffer, BufferDescriptor const& srcDesc,
                              DST_BUFFER* dstBuffer, BufferDescriptor const& dstDesc,
                              DST_BUFFER* duBuffer, BufferDescriptor const& duDesc,
                              DST_BUFFER* dvBuffer, BufferDescriptor const& dvDesc,
                              DST_BUFFER* duuBuffer, BufferDescriptor const& duuDesc,
                              DST_BUFFER* duvBuffer, BufferDescriptor const& duvDesc,
                              DST_BUFFER* dvvBuffer, BufferDescriptor const& dvvDesc,
                              int numPatchCoords, PATCHCOORD_BUFFER* patchCoords,
                              VkPatchTable const* patchTable, int fvarChannel = 0) const {
    return EvalPatchesFaceVarying(srcBuffer, srcDesc, dstBuffer, dstDesc, duBuffer, duDesc,
                                  dvBuffer, dvDesc, duuBuffer, duuDesc, duvBuffer, duvDesc,
                                  dvvBuffer, dvvDesc, numPatchCoords, patchCoords, patchTable,
                                  fvarChannel, this);
  }

  // By handles, of any kind of patches.

  bool EvalPatches(VkBuffer srcBuffer, BufferDescriptor const& srcDesc, VkBuffer dstBuffer,
                   BufferDescriptor const& dstDesc, int numPatchCoords, VkBuffer patchCoords,
                   PatchBuffers const* patches) const {
    return evalPatches(_deviceContext, {srcBuffer, srcDesc},
                       destinations(_deviceContext, dstBuffer, dstDesc), numPatchCoords,
                       patchCoords, patches);
  }

  bool EvalPatches(VkBuffer srcBuffer, BufferDescriptor const& srcDesc, VkBuffer dstBuffer,
                   BufferDescriptor const& dstDesc, VkBuffer duBuffer,
                   BufferDescriptor const& duDesc, VkBuffer dvBuffer,
                   BufferDescriptor const& dvDesc, int numPatchCoords, VkBuffer patchCoords,
                   PatchBuffers const* patches) const {
    return evalPatches(
        _deviceContext, {srcBuffer, srcDesc},
        destinations(_deviceContext, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc),
        numPatchCoords, patchCoords, patches);
  }

  bool EvalPatches(VkBuffer srcBuffer, BufferDescriptor const& srcDesc, VkBuffer dstBuffer,
                   BufferDescriptor const& dstDesc, VkBuffer duBuffer,
                   BufferDescriptor const& duDesc, VkBuffer dvBuffer,
                   BufferDescriptor const& dvDesc, VkBuffer duuBuffer,
                   BufferDescriptor const& duuDesc, VkBuffer duvBuffer,
                   BufferDescriptor const& duvDesc, VkBuffer dvvBuffer,
                   BufferDescriptor const& dvvDesc, int numPatchCoords, VkBuffer patchCoords,
                   PatchBuffers const* patches) const {
    return evalPatches(
        _deviceContext, {srcBuffer, srcDesc},
        destinations(_deviceContext, dstBuffer, dstDesc, duBuffer, duDesc, dvBuffer, dvDesc,
                     duuBuffer, duuDesc, duvBuffer, duvDesc, dvvBuffer, dvvDesc),
        numPatchCoords, patchCoords, patches);
  }

 protected:
  using VkEvaluator::VkEvaluator;

 private:
  static bool evalPatches(VkDeviceContext* deviceContext, Bound const& src, Destinations const& to,
                          int numPatchCoords, VkBuffer patchCoords, PatchBuffers const* patches);
};

}  // namespace planish::osd
