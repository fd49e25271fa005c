#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "model.h"
#include "pipelines.h"

namespace planish::viewer {

/// What one frame in flight of the animated shape has for itself: the given points, planish's
/// Solve, the vertices that it writes and its status.
class Frame {
 public:
  Frame(const Device& device, vulkan::Context& context, const Model& model,
        const Pipelines& pipelines, std::uint32_t max_iterations);

  /// To be written before the frame is submitted, once its last submission is done.
  [[nodiscard]] std::span<glm::vec3> points() const;
  /// Of the last solve, once its submission is done.
  [[nodiscard]] vulkan::GpuStatus status() const;

  [[nodiscard]] const vulkan::Solve& solve() const { return solve_; }
  [[nodiscard]] VkBuffer vertices() const { return vertices_; }
  [[nodiscard]] VkBuffer status_target() const { return status_; }
  [[nodiscard]] VkDescriptorSet set() const { return set_; }

 private:
  void write_set(VkDevice device, const Model& model, VkDescriptorSetLayout layout);

  Buffer points_, vertices_, status_;
  vulkan::Solve solve_;
  OwnedDescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace planish::viewer
