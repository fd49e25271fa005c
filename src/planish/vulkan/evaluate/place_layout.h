#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>

namespace planish::vulkan {

/// A place on the surface: a face, as the mesh numbers them, and u and v as SurfaceParameter has
/// them (mesh/surface_parameter.h).
struct SurfacePlace {
  std::uint32_t face;
  float u, v;
};
static_assert(sizeof(SurfacePlace) == 12);

/// Places on the surface: `count` records, `stride` bytes apart, of which each begins with a
/// SurfacePlace. They may be anything: kernels read nothing by what they have not checked. The
/// buffer is the host's, has VK_BUFFER_USAGE_STORAGE_BUFFER_BIT and outlives the Places. No buffer:
/// the Places have one of their own of 12 bytes a record, which record_list fills.
struct PlaceList {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  std::uint32_t stride = 12;
  std::uint32_t count = 0;
};

/// What came of a place.
enum class PlaceState : std::uint32_t {
  Regular = 0,
  /// At a vertex or face centre of other valence or size than 4, or within 2^-24 of it: second
  /// derivatives have no limit there and are 0, du and dv are those along the corner's edges.
  Singular = 1,
  /// No such face, or (u, v) is not in it (by more than 1e-6) or no number: all results are 0.
  None = 2,
};

/// Of a result's offset: it is not written.
inline constexpr std::uint32_t kNotWritten = 0xffffffff;

/// Where Places write: for each place what has an offset: three floats of position, unit normal
/// (zero where tangents are parallel) and derivatives by u and v, in the model's unit, and a
/// PlaceState. Other bytes are left alone. The buffer is the host's, has
/// VK_BUFFER_USAGE_STORAGE_BUFFER_BIT and outlives the Places. No byte has two meanings, or is one
/// of the list's.
struct PlaceLayout {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;    ///< of the first place's results
  std::uint32_t stride = 88;  ///< bytes
  std::uint32_t position_offset = 0, normal_offset = 12;
  std::uint32_t du_offset = 24, dv_offset = 36;
  std::uint32_t duu_offset = 48, duv_offset = 60, dvv_offset = 72;
  std::uint32_t state_offset = 84;
};

struct PlacesOptions {
  PlaceList list;
  PlaceLayout results;
  std::uint32_t instance = 0;  ///< of the Solve's
};

}  // namespace planish::vulkan
