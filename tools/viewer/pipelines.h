#pragma once

#include <cstdint>
#include <span>

#include "device.h"
#include "handles.h"
#include "shared.h"

namespace planish::viewer {

/// The viewer's shaders as pipelines, all with one layout: two descriptor sets of storage buffers
/// (shared.h) and shared::DrawParameters as push constants.
struct Pipelines {
  Pipelines(const Device& device, VkRenderPass pass);

  OwnedSetLayout set_layout, surface_layout;
  OwnedPipelineLayout layout;
  OwnedGraphicsPipeline background, surface, textured, edges, hidden_edges, points;
  OwnedGraphicsPipeline patches;  // where the device has tessellation
  OwnedComputePipeline vertex_error;
};

/// Who sees the push constants.
[[nodiscard]] VkShaderStageFlags push_stages(const Device& device);

using Words = std::span<const std::uint32_t>;
enum class Blend {
  None,
  Over,
  Sum,
};

/// How one kind of thing is drawn.
struct Drawing {
  Words vertex, fragment;
  bool has_vertices = false;  ///< of the surface; else the vertex shader makes them
  bool tests_depth = true;
  Blend blend = Blend::None;
  Words control{}, evaluation{};  ///< of tessellation: patches of one point
  bool has_uvs = false;           ///< with has_vertices: in a buffer of their own
};
/// Of storage buffers, from binding 0 on.
[[nodiscard]] OwnedSetLayout make_set_layout(VkDevice device, std::uint32_t count,
                                             VkShaderStageFlags stages);
[[nodiscard]] VkDescriptorSet make_set(VkDevice device, VkDescriptorPool pool,
                                       VkDescriptorSetLayout layout,
                                       std::span<const VkDescriptorBufferInfo> buffers);
/// With shared::DrawParameters as push constants.
[[nodiscard]] OwnedPipelineLayout make_layout(const Device& device,
                                              std::span<const VkDescriptorSetLayout> sets);
/// Viewport and scissor are left to the command buffer.
[[nodiscard]] OwnedGraphicsPipeline make_drawing(VkDevice device, VkRenderPass pass,
                                                 VkPipelineLayout layout, const Drawing& drawing);

}  // namespace planish::viewer
