#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/vulkan/embed.h"
#include "planish/vulkan/tables/device_table.h"
#include "planish/vulkan/tables/stencil_pass.h"

namespace planish::vulkan {

/// States of the refinement levels and descriptor sets that take control points to limit points and
/// normals in a host's layout. Externally synchronised; tables and control points outlive it.
class GpuEvaluation {
 public:
  /// `refinement` and `limit` are a System's tables, the last made with derivatives and a target
  /// stride of at least the layout's.
  GpuEvaluation(Context& context, std::span<const DeviceTable> refinement, const DeviceTable& limit,
                const Buffer& control_points, const VertexLayout& layout);

  void record(VkCommandBuffer commands) const noexcept;

 private:
  Context& context_;
  const DeviceTable& limit_;
  VertexLayout layout_;
  std::vector<Buffer> states_;
  std::vector<StencilPass> refinement_;
  std::vector<std::uint32_t> first_targets_;  // per slice of the limit table
  DescriptorSets sets_;                       // per slice of the limit table
};

}  // namespace planish::vulkan
