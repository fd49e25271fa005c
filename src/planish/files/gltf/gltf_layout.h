#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/files/gltf/gltf_document.h"

namespace planish {

/// A primitive with vertices of its own, and the names of its group, which may be empty.
struct GltfPrimitive {
  std::uint64_t vertex_count = 0, triangle_count = 0;
  int uv_sets = 0;  ///< TEXCOORD_0, TEXCOORD_1 ...
  std::string name, material;
  std::int32_t group = -1;     ///< of the surface; -1: it has none
  bool encodes_ngons = false;  ///< see GltfOptions::ngon_groups
  /// Of each of GltfLayout::attributes, where the format wants them.
  std::vector<std::optional<GltfBounds>> bounds;

  /// 2 up to kMaxShortIndexVertices, else 4.
  [[nodiscard]] std::uint32_t index_size() const;
  /// Of its indices, without padding.
  [[nodiscard]] std::uint64_t index_bytes() const { return 3 * index_size() * triangle_count; }
};

/// Where the parts of a file's binary buffer lie. First, each for all primitives in turn: POSITION
/// (float32 x 3), NORMAL (float32 x 3), TEXCOORD_0, TEXCOORD_1 ... (float32 x 2) of those that have
/// any, COLOR_0 (float32 x 4) where there are any, row_attributes(); then the triangle indices of
/// each primitive. Every part starts on a multiple of 4.
struct GltfLayout {
  bool has_colors = false;
  std::vector<GltfAttribute> attributes;  ///< those behind the others
  std::vector<GltfPrimitive> primitives;
  std::uint64_t vertex_count = 0, triangle_count = 0;  ///< of all primitives
  std::uint64_t buffer_bytes = 0;                      ///< of all, padded to a multiple of 4
};

/// Most vertices that 16-bit indices are used for. One less than their largest value, which some
/// graphics interfaces take for a primitive restart.
inline constexpr std::uint64_t kMaxShortIndexVertices = 65534;

/// Bytes up to a multiple of four, on which every part of a buffer starts.
[[nodiscard]] inline std::uint64_t padded(std::uint64_t bytes) { return (bytes + 3) / 4 * 4; }

/// "TEXCOORD_1" of set 1.
[[nodiscard]] inline std::string uv_name(int set) { return "TEXCOORD_" + std::to_string(set); }
/// 1 of "TEXCOORD_1"; -1: it is no such name.
[[nodiscard]] int uv_set(std::string_view attribute);

/// Bytes of a vertex, a multiple of 4: integers that are fewer have zeros behind them.
[[nodiscard]] inline std::uint64_t attribute_bytes(const GltfAttribute& attribute) {
  return padded(static_cast<std::uint64_t>(attribute.width) * (attribute.is_integer ? 2 : 4));
}

/// Fields and attributes of the options, as they are written.
[[nodiscard]] std::vector<GltfAttribute> row_attributes(const GltfOptions& options);

/// One primitive without texture coordinates, colours and names.
[[nodiscard]] GltfLayout gltf_layout(std::uint64_t vertex_count, std::uint64_t triangle_count);
/// Gives a layout of has_colors, fields and primitives its sizes.
void set_sizes(GltfLayout& layout);

/// The document of a layout; `bounds` are those of the primitives.
[[nodiscard]] GltfDocument plain_document(const GltfLayout& layout,
                                          std::span<const GltfBounds> bounds,
                                          const GltfOptions& options);

/// Header of a GLB and of its two chunks.
inline constexpr std::uint64_t kGlbHeaderBytes = 12, kGlbChunkHeaderBytes = 8;

/// Bytes of the GLB of a JSON text (before padding) and a buffer.
/// Throws Error{InvalidArgument} naming `name` where they do not fit a GLB's 32-bit length.
[[nodiscard]] std::uint64_t glb_byte_count(std::uint64_t json_bytes, std::uint64_t buffer_bytes,
                                           std::string_view name);

}  // namespace planish
