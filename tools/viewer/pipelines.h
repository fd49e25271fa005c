#pragma once

#include "handles.h"
#include "shared.h"

namespace planish::viewer {

/// The viewer's shaders as pipelines, all with one layout: a descriptor set of storage buffers
/// (shared.h) and shared::DrawParameters as push constants.
struct Pipelines {
  Pipelines(VkDevice device, VkRenderPass pass);

  OwnedSetLayout set_layout;
  OwnedPipelineLayout layout;
  OwnedGraphicsPipeline background, surface, edges, hidden_edges, points;
  OwnedComputePipeline vertex_error;
};

/// Who sees the push constants.
inline constexpr VkShaderStageFlags kPushStages =
    VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;

}  // namespace planish::viewer
