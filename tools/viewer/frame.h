#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "model.h"
#include "pipelines.h"

namespace planish::viewer {

/// What one frame in flight of the animated shape has for itself, its slot of planish's Solve: the
/// given points, the vertices and the status.
class Frame {
 public:
  Frame(const Device& device, vulkan::Context& context, const Model& model);
  /// To be called once: what shaders read, with the control points of the Solve of all frames.
  void bind(VkDevice device, const Model& model, const Pipelines& pipelines,
            const vulkan::Solve& solve);

  /// To be written before the frame is submitted, once its last submission is done.
  [[nodiscard]] std::span<glm::vec3> points() const;
  /// Of the last solve, once its submission is done.
  [[nodiscard]] vulkan::GpuStatus status() const;

  [[nodiscard]] vulkan::FrameSlot slot() const;
  [[nodiscard]] VkBuffer vertices() const { return vertices_; }
  [[nodiscard]] VkBuffer status_target() const { return status_; }
  [[nodiscard]] VkDescriptorSet set() const { return set_; }
  /// Of the surface as shader code reads it.
  [[nodiscard]] VkDescriptorSet surface_set() const { return surface_set_; }

 private:
  Buffer points_, vertices_, status_;
  OwnedDescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE, surface_set_ = VK_NULL_HANDLE;
};

}  // namespace planish::viewer
