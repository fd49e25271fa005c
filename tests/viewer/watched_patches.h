#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "viewer/device.h"
#include "viewer/renderer.h"

namespace planish::testing {

/// A vertex that the tessellation made.
struct PatchVertex {
  float corner, u, v;
  glm::vec3 position;
};
static_assert(sizeof(PatchVertex) == 24);

/// The viewer's patches of a mesh, which is its own cage, by the viewer's vertex and control
/// shaders.
class WatchedPatches {
 public:
  /// `device` captures.
  WatchedPatches(const viewer::Device& device, const PolygonMesh& mesh, VkExtent2D extent);

  void draw(const viewer::OrbitCamera& camera);
  /// Of the last draw, three a triangle.
  [[nodiscard]] std::span<const PatchVertex> vertices() const;
  /// How many layers face the eye and turn away at each pixel, 64 a layer (16 a sample).
  [[nodiscard]] std::span<const std::array<std::uint8_t, 4>> layers() const;

 private:
  const viewer::Device& device_;
  VkExtent2D extent_;
  viewer::OwnedRenderPass pass_;
  viewer::Image image_;
  viewer::Targets targets_;
  vulkan::Context context_;
  viewer::Pipelines pipelines_;
  viewer::Model model_;
  viewer::Frame frame_;
  std::unique_ptr<vulkan::Solve> solve_;
  viewer::Buffer made_, byte_count_, picture_;
  viewer::OwnedGraphicsPipeline pipeline_;
  PFN_vkCmdBindTransformFeedbackBuffersEXT bind_;
  PFN_vkCmdBeginTransformFeedbackEXT begin_;
  PFN_vkCmdEndTransformFeedbackEXT end_;
};

}  // namespace planish::testing
