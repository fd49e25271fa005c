#pragma once

#include <opensubdiv/osd/types.h>

#include <memory>
#include <span>

#include "planish/osd/vk_device_context.h"
#include "planish/vulkan/device/buffer.h"

namespace planish::osd {

/// One kind of a patch table's patches, as shaders/evaluate/elements.comp reads them.
struct PatchBuffers {
  OpenSubdiv::Osd::PatchArrayVector patchArrays;
  int numPoints = 0;  ///< elements that the patches read: the highest index + 1
  vulkan::Buffer arrays, indices;
  std::shared_ptr<vulkan::Buffer> params;  ///< vertex and varying patches have the same ones
};

/// Uploads. Throws planish::Error{OutOfMemory}, naming the limit.
std::shared_ptr<PatchBuffers> MakePatchBuffers(OpenSubdiv::Osd::PatchArrayVector const& patchArrays,
                                               std::span<int const> indices,
                                               std::shared_ptr<vulkan::Buffer> params,
                                               VkDeviceContext& deviceContext);
std::shared_ptr<vulkan::Buffer> MakeParamBuffer(OpenSubdiv::Osd::PatchParamVector const& params,
                                                VkDeviceContext& deviceContext);

}  // namespace planish::osd
