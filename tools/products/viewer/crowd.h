#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <vector>

#include "device.h"
#include "scene.h"

namespace planish::viewer {

struct CrowdOptions {
  VkExtent2D extent{1280, 720};
  std::uint32_t count = 1000;
  std::vector<int> levels = {1, 2, 3, 4};
  int iterations = 6;  ///< of each frame
  float chord_pixels = 0.5f;
  bool motions = false;  ///< are drawn, too
  float walk = 0;        ///< of the eye, ahead, in diagonals of the mesh a second
};

/// What a view came to.
struct CrowdFigures {
  std::vector<std::uint32_t> instances;  ///< of each level
  std::uint32_t unseen = 0;
  std::uint64_t triangles = 0;
};

/// Instances of a scene's mesh in rows from near to far, each moving by itself, each at the level
/// that its place in the picture needs: planish's Tessellation, off-screen. With squares by texture
/// coordinates where the scene's system is textured.
class Crowd {
 public:
  Crowd(const Device& device, Scene scene, const CrowdOptions& options);

  /// Draws the next frames of the animation, each 1/60 s after the one before, and waits for each.
  void run(int frames);
  /// Of the last frame.
  [[nodiscard]] CrowdFigures figures() const;
  /// RGB, top row first.
  [[nodiscard]] std::vector<std::uint8_t> picture() const;
  /// Of each pixel how far what it shows has moved since the frame before, in pixels, and its
  /// texture coordinates; zeros where there is no instance. CrowdOptions::motions.
  [[nodiscard]] std::vector<glm::vec4> motions() const;

 private:
  /// What is drawn into.
  struct Layer {
    Layer(const Device& device, VkFormat format, VkExtent2D extent);
    OwnedRenderPass pass;
    Image image;
    Targets targets;
  };
  [[nodiscard]] glm::vec3 offset_of(std::uint32_t instance) const;
  [[nodiscard]] std::vector<std::uint32_t> places() const;
  /// Throws Error{OutOfMemory} where the device has no bindings for so many.
  [[nodiscard]] VkDeviceSize point_bytes() const;
  [[nodiscard]] vulkan::TessellationOptions levels() const;
  [[nodiscard]] Buffer uvs() const;
  void look(double seconds);
  void pose(double seconds);
  void bind(VkCommandBuffer commands, VkPipelineLayout layout, VkPipeline pipeline) const;
  void draw(VkCommandBuffer commands, VkPipeline pipeline) const;

  const Device& device_;
  CrowdOptions options_;
  Layer colours_;
  std::optional<Layer> motions_;
  vulkan::Context context_;
  Pipelines pipelines_;
  CrowdPipelines drawings_;
  Animation animation_;
  glm::vec3 middle_{0};
  float size_ = 1;  // of the mesh's diagonal
  vulkan::System system_;
  vulkan::DeviceSystem tables_;
  std::size_t corner_count_;
  Buffer points_, vertices_, uvs_, before_;
  OwnedDescriptorPool pool_;
  VkDescriptorSet set_;
  vulkan::Solve solve_;
  vulkan::Tessellation levels_;
  shared::DrawParameters view_{};
  int next_frame_ = 0;
};

}  // namespace planish::viewer
