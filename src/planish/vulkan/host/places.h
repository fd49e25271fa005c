#pragma once

#include <cstdint>
#include <memory>

#include "planish/vulkan/device/context.h"
#include "planish/vulkan/evaluate/place_layout.h"
#include "planish/vulkan/host/solve_options.h"

// Part of embed.h: the surface at any place.

namespace planish::vulkan {

class DeviceSystem;
class Solve;

/// The surface of a Solve at a list of places, hole faces included: LimitSurface's values in single
/// precision, positions to about 1e-7 of the largest coordinate, derivatives to 1e-5 of their size
/// around the place. Externally synchronised, with its Solve.
class Places {
 public:
  /// `system` was made with answers_places, `solve` on it. Throws Error{InvalidArgument},
  /// Error{OutOfMemory} naming the limit, VulkanError.
  Places(Context& context, const DeviceSystem& system, const Solve& solve,
         const PlacesOptions& options);
  ~Places();
  Places(Places&&) noexcept;
  Places& operator=(Places&&) noexcept;

  /// Copies places, 12 tight bytes each, from a host's buffer with
  /// VK_BUFFER_USAGE_TRANSFER_SRC_BIT; offset is a multiple of 4. Only without a list's buffer.
  void record_list(VkCommandBuffer commands, VkBuffer source, VkDeviceSize offset) const noexcept;
  /// Evaluates the first `count` places of the list, at most all, on the surface of the Solve's
  /// last record_evaluate or record_surface.
  void record_evaluate(VkCommandBuffer commands, std::uint32_t count = 0xffffffff,
                       const Timestamps& timestamps = {}) const noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// What the surface as shader code reads, share/planish/shaders/planish_surface.glsl of the
/// package: read-only arrays of uint, uvec2 and vec4, at any bindings of the host's own pipelines,
/// of any stage.
struct SurfaceBuffers {
  VkDescriptorBufferInfo words, links, state, given, weights;
  std::uint32_t face_count, corner_count;
};
/// Of an instance. `system` was made with answers_places, `solve` on it; both outlive what is
/// bound. Read them behind a barrier from kExitScope, after record_evaluate or record_surface, and
/// be done, by a barrier to kEntryScope, before the next frame's work. Draws of patches keep, on
/// Mesa's llvmpipe (22.3), below 1,024 corners, where gl_PrimitiveID begins anew, and 65,535
/// generated vertices, beyond which it draws none. Throws Error{InvalidArgument}.
[[nodiscard]] SurfaceBuffers surface_buffers(const DeviceSystem& system, const Solve& solve,
                                             std::uint32_t instance = 0);

}  // namespace planish::vulkan
