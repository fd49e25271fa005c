#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "planish/vulkan/device/context.h"
#include "planish/vulkan/host/solve_options.h"

namespace planish::vulkan {

// Part of embed.h: the surface at any place.

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

// Part of embed.h: levels by need.

struct TessellationOptions {
  /// Where vertices of all levels go, those of SystemOptions::levels one after another: for each as
  /// many instances as `places` says, a whole instance after the other. `instance_stride` says
  /// nothing; attributes are in the same buffer. The buffer has
  /// DeviceSystem::tessellation_bytes() and VK_BUFFER_USAGE_STORAGE_BUFFER_BIT.
  VertexLayout vertices;
  /// How many instances each level has room for, one a level, the first for all of the Solve's;
  /// empty: all of them for all. Where more want a level, those of higher numbers take a coarser
  /// one. All vertices of a level are one binding, 128 MiB on many devices: fine levels of many
  /// instances want fewer places.
  std::vector<std::uint32_t> places;
  /// Where each vertex's position of the view before goes, for motion vectors: of the pose that the
  /// last record_evaluate or record_reset saw, at the level that its instance has now, in the
  /// format and box of its position. Of a buffer with VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, the
  /// vertices' own or another one. A stride of 0: nowhere. `instance_stride` says nothing. Takes 32
  /// bytes of the device a used vertex of each instance; of the fair method 16, and 16 a corner.
  VertexStream previous_positions;
  /// A draw's firstInstance is the instance's number, not 0, and a level's draw begins with its own
  /// instances among those of all levels: the host enabled drawIndirectFirstInstance.
  bool numbers_draws = false;
};

/// What a level's draw has of each instance, for a vertex buffer at VK_VERTEX_INPUT_RATE_INSTANCE.
struct DrawnInstance {
  std::uint32_t instance;  ///< its number
  /// Added to gl_VertexIndex: which of TessellationOptions::vertices the vertex is.
  std::uint32_t first_vertex;
};
static_assert(sizeof(DrawnInstance) == 8);

/// The one draw of all instances at a level.
struct LevelDraw {
  /// A VkDrawIndexedIndirectCommand, those of finer levels behind it. Its vertexOffset is that of a
  /// stream of vertices of all levels one after another, an instance of each, whatever is drawn.
  VkBuffer draw = VK_NULL_HANDLE;
  VkDeviceSize draw_offset = 0;
  VkBuffer instances = VK_NULL_HANDLE;  ///< DrawnInstance records
  VkDeviceSize instances_offset = 0;    ///< the first level's if TessellationOptions::numbers_draws
};

/// What levels are chosen for.
struct TessellateParameters {
  /// From the world to Vulkan's clip space (0 <= z <= w), column by column: glm::mat4. Perspective
  /// or orthographic, depth either way, near or infinite far plane.
  std::array<float, 16> clip_from_world{};
  float viewport_height = 1080;  ///< pixels
  /// How far triangles may be from the surface, in pixels, seen square on.
  float chord_pixels = 0.5f;
  /// A coarser level is taken once it leaves no more than this share of chord_pixels, so that an
  /// instance at a limit does not pop to and fro. 1: at once.
  float coarser_at = 0.7f;
  Timestamps timestamps;
};

/// The surface of each instance of a Solve at a level of its own, as fine as it is seen, chosen on
/// the device; what is off screen is neither evaluated nor drawn. Externally synchronised, with its
/// Solve.
///
///   tessellation.record_evaluate(commands, {.clip_from_world = ...});  // after record_solve
///   vkCmdBindIndexBuffer(commands, tessellation.indices(), 0, VK_INDEX_TYPE_UINT32);
///   for (i = 0; i < solve.instance_count(); ++i)                       // or one multi-draw
///     vkCmdDrawIndexedIndirect(commands, tessellation.draws(), i * kDrawStride, 1, kDrawStride);
///
/// An instance is seen where the sphere around its control points, which its surface does not
/// leave, meets the view. Its level is the first whose chord error, System::chord_errors() in
/// proportion to that sphere, is at most chord_pixels at the sphere's nearest point: measured in
/// the rest pose, so poses that bend much more want fewer pixels. Vertices have the bits of
/// record_evaluate of a System of that level. Several views: a Tessellation each.
///
/// Texture coordinates, places and whatever else is the same for all instances are streams of the
/// host's own, of System::uvs(level) of all levels one after another. They want level_draw(): one
/// draw a level, whose vertex shader reads positions and normals from a storage buffer, at
/// DrawnInstance::first_vertex + gl_VertexIndex (vulkan/details.md has all of it). Draws of single
/// instances have offsets of their own vertices, at which no stream of the level can be bound.
class Tessellation {
 public:
  /// `system` was made of a System with levels, `solve` on it. Throws Error{InvalidArgument},
  /// Error{OutOfMemory} naming the limit, VulkanError.
  Tessellation(Context& context, const DeviceSystem& system, const Solve& solve,
               const TessellationOptions& options);
  ~Tessellation();
  Tessellation(Tessellation&&) noexcept;
  Tessellation& operator=(Tessellation&&) noexcept;

  /// Forgets what levels the last view had: before the first, and after a cut. Previous positions
  /// are then those of the last solve, so it comes behind record_solve where they are written.
  void record_reset(VkCommandBuffer commands) const noexcept;
  /// Chooses levels and evaluates what is seen, of the last solve of whatever slot. Instead of
  /// record_evaluate and record_surface; what Places and surface_buffers() read is then made of
  /// what is seen alone. The host waits for its draws by a barrier to kEntryScope before, and
  /// afterwards from kExitScope to VERTEX_INPUT and DRAW_INDIRECT (VERTEX_ATTRIBUTE_READ,
  /// INDIRECT_COMMAND_READ).
  void record_evaluate(VkCommandBuffer commands,
                       const TessellateParameters& parameters) const noexcept;
  /// Copies a uint32 for each instance to a host's buffer, as Solve::record_status does: the place
  /// of its level among SystemOptions::levels, or kNotSeen.
  void record_levels(VkCommandBuffer commands, VkBuffer target, VkDeviceSize offset) const noexcept;

  /// A VkDrawIndexedIndirectCommand of each instance, of no index where it is not seen.
  [[nodiscard]] VkBuffer draws() const;
  static constexpr std::uint32_t kDrawStride = sizeof(VkDrawIndexedIndirectCommand);
  static constexpr std::uint32_t kNotSeen = 0xffffffff;
  /// `level` is a place among SystemOptions::levels. To be read by VERTEX_INPUT and DRAW_INDIRECT
  /// as draws() are.
  [[nodiscard]] LevelDraw level_draw(std::size_t level) const;
  /// uint32 indices of all levels.
  [[nodiscard]] VkBuffer indices() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace planish::vulkan
