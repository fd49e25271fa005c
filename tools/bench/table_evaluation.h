#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/vulkan/embed.h"
#include "planish/vulkan/tables/device_table.h"
#include "planish/vulkan/tables/stencil_pass.h"

namespace planish::bench {

/// What corner patches replaced in a host's frame: stencil tables on the device that take control
/// points from level to level, and to limit points and normals in a host's layout. Tables and
/// control points outlive it.
class TableEvaluation {
 public:
  /// `limit` was made with derivatives and a target stride of at least the layout's; `refinement`
  /// has a step at least.
  TableEvaluation(vulkan::Context& context, std::span<const vulkan::DeviceTable> refinement,
                  const vulkan::DeviceTable& limit, VkBuffer control_points,
                  const vulkan::VertexLayout& layout);

  void record(VkCommandBuffer commands) const noexcept;

 private:
  vulkan::Context& context_;
  const vulkan::DeviceTable& limit_;
  vulkan::VertexLayout layout_;
  std::vector<vulkan::Buffer> states_;
  std::vector<vulkan::StencilPass> refinement_;
  std::vector<std::uint32_t> first_targets_;  // per slice of the limit table
  vulkan::DescriptorSets sets_;               // per slice of the limit table
};

}  // namespace planish::bench
