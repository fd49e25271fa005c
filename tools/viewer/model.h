#pragma once

// With prototypes, which planish's headers would leave out.
#include <vulkan/vulkan.h>

#include <span>
#include <vector>

#include "planish/vulkan/embed.h"
#include "resources.h"
#include "scene.h"
#include "shared.h"

namespace planish::viewer {

/// What all frames share: planish's tables of a scene at one level, the surface's indices, and what
/// the viewer draws and measures with. Read-only once made.
class Model {
 public:
  /// Uploads, and waits for it.
  Model(const Device& device, vulkan::Context& context, const Scene& scene);

  [[nodiscard]] const vulkan::System& system() const { return system_; }
  [[nodiscard]] const vulkan::DeviceSystem& tables() const { return tables_; }
  [[nodiscard]] VkBuffer indices() const { return indices_; }
  /// Of each vertex two floats; null where the mesh has no texture coordinates.
  [[nodiscard]] VkBuffer uvs() const { return uvs_; }
  [[nodiscard]] std::uint32_t edge_count() const { return edge_count_; }
  [[nodiscard]] std::uint32_t used_count() const {
    return static_cast<std::uint32_t>(system_.used_vertices().size());
  }

  /// Corners of the faces that are no holes, each a patch, by runs of their numbers. What a run
  /// counts beyond its end is not drawn.
  struct Run {
    std::uint32_t first, count, end;
  };
  [[nodiscard]] std::span<const Run> patches() const { return patches_; }
  [[nodiscard]] std::uint32_t face_count() const { return face_count_; }

  /// Bindings kUsedBinding to kNearestBinding of shared.h.
  [[nodiscard]] VkBuffer used() const { return used_; }
  [[nodiscard]] VkBuffer edges() const { return edges_; }
  [[nodiscard]] VkBuffer offsets() const { return offsets_; }
  [[nodiscard]] VkBuffer nearest() const { return nearest_; }

 private:
  vulkan::System system_;
  vulkan::DeviceSystem tables_;
  Buffer indices_, used_, edges_;
  std::uint32_t edge_count_;
  Buffer offsets_, nearest_, uvs_;
  std::vector<Run> patches_;
  std::uint32_t face_count_;
};

}  // namespace planish::viewer
