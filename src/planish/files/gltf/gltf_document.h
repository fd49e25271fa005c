#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "planish/files/gltf/write_gltf.h"

namespace planish {

/// A primitive: its triangles and the names of its group, which may be empty.
struct GltfPrimitive {
  std::uint64_t triangle_count = 0;
  std::string name, material;
};

/// Where the parts of a file's binary buffer lie, in bytes: POSITION (float32 x 3), NORMAL
/// (float32 x 3), TEXCOORD_0 (float32 x 2) and COLOR_0 (float32 x 4) where there are any, fields
/// (float32 each), then the triangle indices of each primitive. Every part starts on a multiple
/// of 4.
struct GltfLayout {
  std::uint64_t vertex_count = 0, triangle_count = 0;
  std::uint32_t index_size = 4;       ///< 2 up to kMaxShortIndexVertices, else 4
  std::uint64_t attribute_bytes = 0;  ///< of POSITION, and again of NORMAL
  bool has_uvs = false, has_colors = false;
  std::vector<std::string> fields;  ///< attributes behind those, by name
  std::vector<GltfPrimitive> primitives;
  std::uint64_t buffer_bytes = 0;  ///< of all, padded to a multiple of 4

  /// Of a primitive's indices, without padding.
  [[nodiscard]] std::uint64_t index_bytes(std::size_t primitive) const {
    return 3 * index_size * primitives[primitive].triangle_count;
  }
};

/// Most vertices that 16-bit indices are used for. One less than their largest value, which some
/// graphics interfaces take for a primitive restart.
inline constexpr std::uint64_t kMaxShortIndexVertices = 65534;

/// Header of a GLB and of its two chunks.
inline constexpr std::uint64_t kGlbHeaderBytes = 12, kGlbChunkHeaderBytes = 8;

/// Without texture coordinates, colours and groups.
[[nodiscard]] GltfLayout gltf_layout(std::uint64_t vertex_count, std::uint64_t triangle_count);
/// Gives a layout of vertex_count, has_uvs, has_colors, fields and primitives its sizes.
void set_sizes(GltfLayout& layout);

/// Bytes of the GLB of a JSON text (before padding) and a buffer.
/// Throws Error{InvalidArgument} naming `name` where they do not fit a GLB's 32-bit length.
[[nodiscard]] std::uint64_t glb_byte_count(std::uint64_t json_bytes, std::uint64_t buffer_bytes,
                                           std::string_view name);

/// Smallest and largest float32 coordinates that are stored.
struct GltfBounds {
  glm::vec3 minimum, maximum;
};

/// The glTF JSON as tinygltf writes it, keys sorted. An empty buffer_uri stands for a GLB's binary
/// chunk and gives the text without white space. Text that is not UTF-8 and non-finite numbers
/// become U+FFFD and null.
[[nodiscard]] std::string gltf_json(const GltfLayout& layout, const GltfBounds& bounds,
                                    const GltfOptions& options, std::string_view buffer_uri);

/// A file name as a relative URI: all but letters, digits and -._~ percent-encoded.
[[nodiscard]] std::string encode_uri(std::string_view file_name);

}  // namespace planish
