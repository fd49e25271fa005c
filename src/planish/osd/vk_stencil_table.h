#pragma once

#include <opensubdiv/far/stencilTable.h>

#include <array>
#include <memory>

#include "planish/osd/vk_device_context.h"

namespace planish::vulkan {
class DeviceTable;
}

namespace planish::osd {

/// What a stencil's weights yield.
enum class StencilWeights { Value, Du, Dv, Duu, Duv, Dvv };
inline constexpr int kStencilWeightsCount = 6;

/// OpenSubdiv's STENCIL_TABLE on a Vulkan device, in the layout that planish's own solver walks
/// (shaders/shared.h). Read only. May be deleted at any time in the
/// life of the device context that made it, like a VkVertexBuffer.
class VkStencilTable {
 public:
  /// Copies the table to the device; it may be deleted then. The caller owns the result. Throws
  /// planish::Error: OutOfMemory naming the limit; InvalidArgument for a stencil that reads another
  /// stencil's result (factorizeIntermediateLevels = false), which no parallel evaluator can take.
  static VkStencilTable* Create(OpenSubdiv::Far::StencilTable const* table,
                                VkDeviceContext* deviceContext);
  /// With the derivative weights that it has.
  static VkStencilTable* Create(OpenSubdiv::Far::LimitStencilTable const* table,
                                VkDeviceContext* deviceContext);
  ~VkStencilTable();
  VkStencilTable(VkStencilTable const&) = delete;
  VkStencilTable& operator=(VkStencilTable const&) = delete;

  int GetNumStencils() const { return _numStencils; }
  int GetNumControlVertices() const { return _numControlVertices; }

  /// Null where the table has no such weights.
  vulkan::DeviceTable const* GetWeights(StencilWeights weights) const;

 private:
  VkStencilTable(OpenSubdiv::Far::StencilTableReal<float> const& table,
                 VkDeviceContext& deviceContext);

  int _numStencils, _numControlVertices;
  VkDeviceContext& _deviceContext;
  std::array<std::shared_ptr<vulkan::DeviceTable>, kStencilWeightsCount> _weights;
};

}  // namespace planish::osd
