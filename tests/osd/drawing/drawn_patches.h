#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <vector>

#include "osd/conformance.h"
#include "planish/osd/vk_patch_table.h"
#include "planish/osd/vk_vertex_buffer.h"
#include "viewer/device.h"

namespace planish::testing {

/// A vertex that the tessellation made.
struct DrawnVertex {
  float patch, u, v;
  glm::vec3 position, du, dv, normal;
};
static_assert(sizeof(DrawnVertex) == 60);

enum class Spacing {
  Equal,
  FractionalEven,
  FractionalOdd,
};

struct DrawOptions {
  Spacing spacing = Spacing::Equal;
  bool by_screen = false;
  float level = 4;
  glm::mat4 clip_from_object{1};
};

/// A cage, its points evaluated on the device.
struct DrawnMesh {
  DrawnMesh(const Cage& cage, const RefineOptions& options, osd::VkDeviceContext& target);

  Refined refined;
  std::unique_ptr<osd::VkVertexBuffer> points;  ///< the cage's, then the refined ones
  std::unique_ptr<osd::VkPatchTable> table;
};

/// Draws patches by planish_osd_patches.glsl and captures what the tessellation makes.
class PatchDrawing {
 public:
  /// `device` captures.
  explicit PatchDrawing(const viewer::Device& device);

  [[nodiscard]] osd::VkDeviceContext& target() { return target_; }
  /// Three vertices a triangle.
  [[nodiscard]] std::vector<DrawnVertex> draw(const DrawnMesh& mesh, const DrawOptions& options);

 private:
  VkPipeline pipeline(const OpenSubdiv::Osd::PatchArray& array, Spacing spacing);
  /// As many patches of an array.
  void record(VkCommandBuffer commands, const DrawnMesh& mesh,
              const OpenSubdiv::Osd::PatchArray& array, int first, int count,
              const DrawOptions& options);

  const viewer::Device& device_;
  vulkan::Context context_;
  osd::VkDeviceContext target_;
  viewer::OwnedRenderPass pass_;
  viewer::OwnedFramebuffer framebuffer_;
  viewer::OwnedSetLayout set_layout_;
  viewer::OwnedPipelineLayout layout_;
  viewer::OwnedDescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  viewer::Buffer made_, byte_count_;
  PFN_vkCmdBindTransformFeedbackBuffersEXT bind_;
  PFN_vkCmdBeginTransformFeedbackEXT begin_;
  PFN_vkCmdEndTransformFeedbackEXT end_;
  std::map<std::pair<int, Spacing>, viewer::OwnedGraphicsPipeline> pipelines_;
};

}  // namespace planish::testing
