#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <cstdint>
#include <vector>

#include "planish/vulkan/device/driver.h"

namespace planish::vulkan {

/// A place on the surface: a face, as the mesh numbers them, and u and v as SurfaceParameter has
/// them (mesh/mesh_topology.h).
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

// What hosts tell Solves of embed.h, and are told by them.

/// Where the points to pass through are: three floats each, `stride` bytes apart, one per vertex of
/// the mesh. The buffer is the host's, has VK_BUFFER_USAGE_STORAGE_BUFFER_BIT and outlives the
/// Solve. No buffer: the Solve has one of its own, which record_given fills.
struct GivenPoints {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  std::uint32_t stride = 12;
  /// Bytes from an instance's first point to the next one's; 0: given_count() strides.
  VkDeviceSize instance_stride = 0;
};

/// How a position, normal or tangent is written; values as a vertex attribute of the VkFormat reads
/// them.
enum class VertexFormat : std::uint32_t {
  Float3 = 0,  ///< VK_FORMAT_R32G32B32_SFLOAT, 12 bytes
  /// Of positions, 8 bytes, the fourth value 1: VK_FORMAT_R16G16B16A16_SFLOAT, 11 binary digits
  /// and at most 65,504, and VK_FORMAT_R16G16B16A16_SNORM, 1/32767 of the box, whose outside is
  /// clamped. Both are (position - box_center) / box_half.
  Half4 = 1,
  Snorm16x4 = 2,
  /// Of normals, 4 bytes: VK_FORMAT_R16G16_SNORM, the point (x, y) of the octahedron |x| + |y| +
  /// |z| = 1 with its lower half folded out, off by at most 7e-5 radians (0, which reads as (0, 0,
  /// 1), where there is none); and VK_FORMAT_A2B10G10R10_SNORM_PACK32, x in the lowest ten bits,
  /// each component off by at most half of 1/511.
  Octahedral16 = 3,
  Snorm10 = 4,  ///< of tangents, too
  /// Of tangents: VK_FORMAT_R32G32B32A32_SFLOAT, 16 bytes.
  Float4 = 5,
};
/// Bytes of a position, normal or tangent.
[[nodiscard]] constexpr std::uint32_t bytes_of(VertexFormat format) {
  return format == VertexFormat::Float3                                       ? 12
         : format == VertexFormat::Float4                                     ? 16
         : format == VertexFormat::Half4 || format == VertexFormat::Snorm16x4 ? 8
                                                                              : 4;
}

/// Attributes of vertices apart from their positions, in a buffer of their own or another part of
/// the same one.
struct VertexStream {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;   ///< of the first vertex's
  std::uint32_t stride = 0;  ///< bytes
  /// Bytes from an instance's first vertex to the next one's; 0: vertex_count() strides.
  VkDeviceSize instance_stride = 0;
};

/// Where record_evaluate writes: for each vertex its position and unit normal (zero where the
/// tangents are parallel), by default three floats each, and its tangent if wanted. Other bytes are
/// left alone. Buffers are the host's, have VK_BUFFER_USAGE_STORAGE_BUFFER_BIT and outlive the
/// Solve. No byte of a vertex has two meanings, or is one that a solve or an edit of any slot
/// reads: Error{InvalidArgument}. No buffer: nothing is evaluated. No format needs a feature of the
/// device: kernels store whole words.
struct VertexLayout {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;    ///< of the first vertex
  std::uint32_t stride = 24;  ///< bytes
  std::uint32_t position_offset = 0;
  std::uint32_t normal_offset = 12;  ///< kNotWritten: there are none, and no tangents
  /// Bytes from an instance's first vertex to the next one's; 0: vertex_count() strides.
  VkDeviceSize instance_stride = 0;
  VertexFormat position_format = VertexFormat::Float3;
  VertexFormat normal_format = VertexFormat::Float3;
  /// Where it has a buffer, normals and tangents stand there, their offsets counted from its
  /// vertices' beginnings: positions by themselves are all that shadows, depth and acceleration
  /// structures read. A slot that takes edits has both in one buffer: their kernel has no binding
  /// left.
  VertexStream attributes;
  /// Of compact positions: the box that they lie in, of any pose. Halves are above 0.
  std::array<float, 3> box_center = {0, 0, 0};
  std::array<float, 3> box_half = {1, 1, 1};
  /// Of tangents; kNotWritten: there are none. The System is textured. As glTF's TANGENT: of unit
  /// length, square to the normal, where u grows; fourth value 1 where the mesh's v (which images
  /// count against) grows along cross(normal, tangent), else -1. It is the surface's own
  /// derivative, so exact at any level, and where faces meet the mean of theirs; MikkTSpace's are
  /// means of triangles by angle, which come close as levels rise. Normal textures that were baked
  /// for those of another mesh differ by as much.
  std::uint32_t tangent_offset = kNotWritten;
  VertexFormat tangent_format = VertexFormat::Float4;
};
[[nodiscard]] constexpr bool has_normals(const VertexLayout& layout) {
  return layout.normal_offset != kNotWritten;
}
[[nodiscard]] constexpr bool has_tangents(const VertexLayout& layout) {
  return layout.tangent_offset != kNotWritten;
}
/// Where normals and tangents are: the attributes' stream, or the vertices.
[[nodiscard]] inline VertexStream attributes_of(const VertexLayout& layout) {
  if (layout.attributes.buffer) return layout.attributes;
  return {layout.buffer, layout.offset, layout.stride, layout.instance_stride};
}

/// A list of points that have moved, for record_edit: a uint32 that counts them, then a uint32 for
/// each, instance * given_count() + its index in the mesh, 0 to max_count of them. It is read when
/// the edit runs, so that a host or a kernel may write it until then. Entries may repeat; what
/// names no point that a face names is passed over, and so is a point that is not finite. The
/// buffer is the host's, has VK_BUFFER_USAGE_STORAGE_BUFFER_BIT and outlives the Solve.
struct MovedPoints {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;      ///< of the count
  std::uint32_t max_count = 0;  ///< a count above it is taken as it
};

/// What one of the frames in flight has for itself.
struct FrameSlot {
  GivenPoints given;
  VertexLayout vertices;
  MovedPoints moved;
};

struct SolveOptions {
  std::uint32_t max_iterations = 64;  ///< that one record_solve can ask for
  /// Of the fair method, 0 to 1000: steps of conjugate gradients that even out the curvature.
  std::uint32_t polish_steps = 8;
  GivenPoints given;      ///< of slot 0
  VertexLayout vertices;  ///< of slot 0
  /// Slots 1, 2, ..., at most kMostSlots with slot 0: one Solve serves all frames in flight. Each
  /// has its own points, which the host writes while earlier frames run, and its own vertices,
  /// which stay as they were while later frames run: those of the last slot are the last frame's
  /// positions, for motion vectors. All else is shared. Layouts may differ from slot to slot; slots
  /// may also share a buffer. A further slot takes a few descriptors and no device memory; with
  /// edits 4 bytes a vertex.
  std::vector<FrameSlot> further_slots;
  /// Of the progressive method, 1 to 65,535: instances of the mesh that every recorded call does,
  /// in the dispatches of one, with one SolveParameters. Each has points, displacement, vertices
  /// and status of its own, stops by itself, and gets the bits that a Solve of its own would give
  /// it. Vectors of all instances (16 bytes a point of level 1, which are the mesh's corners) are
  /// one binding: Error{OutOfMemory} says how many a device can have.
  std::uint32_t instances = 1;
  /// Where record_edit reads what has moved, of slot 0. The DeviceSystem was made with takes_edits.
  /// Edits of all slots together take about 60 bytes a vertex of a quad mesh more; vectors and
  /// tables are one binding each: Error{OutOfMemory} names what is not. No buffer: that slot has no
  /// edits.
  MovedPoints moved;
};

inline constexpr std::uint32_t kMostSlots = 16;

/// Two timestamps in a host's query pool, `first` before and `first` + 1 after the recorded work.
/// The host has reset both queries; its queue family has timestamps.
struct Timestamps {
  VkQueryPool pool = VK_NULL_HANDLE;
  std::uint32_t first = 0;
};

/// Of the progressive method, but for the timestamps: the fair one does all its work each time.
struct SolveParameters {
  /// At most SolveOptions::max_iterations, which stands in for more.
  std::uint32_t iterations = 0;
  /// No iteration once the error is at most this, decided on the device; negative: do them all.
  /// System::tolerance() is what the System promises; steps that are left out cost next to nothing.
  float stop_error = -1;
  /// Starts from the displacement that this Solve's last solve ended with, instead of from none.
  /// record_reset has been run before the first such solve, or a solve without it.
  bool warm_start = false;
  /// Measures the error that the last iteration leaves, at the cost of about one more, unless a
  /// stop came before. Without, the status tells the error before the last iteration.
  bool measures_last = false;
  /// Whose points are taken; counted modulo the number of slots, so that it may be the frame's
  /// number.
  std::uint32_t slot = 0;
  Timestamps timestamps;
};

/// Of an evaluation.
struct EvaluateParameters {
  /// Whose vertices are written; counted modulo the number of slots.
  std::uint32_t slot = 0;
  Timestamps timestamps;
};

/// Of an edit.
struct EditParameters {
  /// At most SolveOptions::max_iterations, which stands in for more. Each can reach one ring of
  /// faces further; 9 take a move of a hundredth of the diagonal below an eighth of
  /// 1e-6 of it on quads.
  std::uint32_t iterations = 24;
  /// No iteration once no point that the edit reaches is off by more, decided on the device for
  /// each instance; negative: do them all. System::tolerance() / 8 leaves control points within the
  /// tolerance of those of a solve from scratch, as the CPU's Editor does.
  float stop_error = -1;
  /// Whose list and points are taken and whose vertices are written; counted modulo the number of
  /// slots.
  std::uint32_t slot = 0;
  Timestamps timestamps;
};

/// What an edit came to, of all instances: words of its own lists.
struct EditReach {
  /// Given points that were looked at, or whose surroundings moved; those that edits of other slots
  /// moved since this one's last edit, too.
  std::uint32_t points;
  std::uint32_t patches;  ///< of corners, vertices, edges and faces, that were evaluated
  std::uint32_t listed;   ///< entries of the host's list that were read
};
static_assert(sizeof(EditReach) == 12);

/// How a solve ended.
enum class SolveState : std::uint32_t {
  Stepped = 0,    ///< all iterations done; no error as low as stop_error was met
  Converged = 1,  ///< an error at or below stop_error was met
  NotFinite = 2,  ///< the error is infinite or no number: so were given points
};

/// What record_status copies.
struct GpuStatus {
  std::uint32_t iterations;
  SolveState state;
  float residual;  ///< largest distance of a given point from its limit point, as measured last
};
static_assert(sizeof(GpuStatus) == 12);

}  // namespace planish::vulkan
