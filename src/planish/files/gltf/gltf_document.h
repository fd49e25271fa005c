#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planish/files/gltf/write_gltf.h"

namespace planish {

/// Component types by their numbers in the format.
enum class GltfComponent : int {
  Byte = 5120,
  UnsignedByte = 5121,
  Short = 5122,
  UnsignedShort = 5123,
  UnsignedInt = 5125,
  Float = 5126
};

/// Smallest and largest coordinates as they are stored.
struct GltfBounds {
  glm::vec3 minimum{0.0f}, maximum{0.0f};
};

/// Where an array lies when EXT_meshopt_compression has packed it.
struct GltfStream {
  std::uint64_t offset = 0, bytes = 0;
  std::string_view mode;             ///< "ATTRIBUTES" or "TRIANGLES"
  std::string_view filter = "NONE";  ///< "OCTAHEDRAL", "EXPONENTIAL"
};

/// An accessor and the buffer view that it has for itself.
struct GltfArray {
  std::string_view type;  ///< "SCALAR", "VEC2" ...
  GltfComponent component = GltfComponent::Float;
  std::uint64_t count = 0;
  bool normalized = false, is_indices = false;
  std::optional<GltfBounds> bounds;
  std::uint32_t buffer = 0;             ///< of several
  std::uint64_t offset = 0, bytes = 0;  ///< decoded, where there is a stream
  std::uint32_t stride = 0;             ///< 0: without gaps
  std::optional<GltfStream> stream;
};

/// A primitive of triangles by its arrays.
struct GltfArrays {
  std::map<std::string, std::size_t> attributes;
  std::size_t indices = 0;
  std::string name, material;
  std::int32_t group = -1;     ///< of the surface; -1: it has none
  bool encodes_ngons = false;  ///< see GltfOptions::ngon_groups
  std::size_t mesh = 0;
};

/// A buffer of several.
struct GltfBuffer {
  std::uint64_t bytes = 0;
  std::string uri;
};

/// What a file's document says: a node for each mesh, all at one place.
struct GltfDocument {
  std::vector<GltfArray> arrays;
  std::vector<GltfArrays> primitives;   ///< those of a mesh together
  std::size_t mesh_count = 1;           ///< several: a buffer for each
  bool shares_materials = false;        ///< primitives of one material's name have it together
  std::uint64_t buffer_bytes = 0;       ///< of all
  std::vector<GltfBuffer> buffers;      ///< empty: there is one
  std::uint64_t decoded_bytes = 0;      ///< of the buffer that streams stand for; 0: none does
  std::vector<std::string> extensions;  ///< required by readers
  glm::dvec3 translation{0.0};
  double scale = 1.0;
};

/// Whether it gets any of the options' materials.
[[nodiscard]] bool takes_materials(const GltfDocument& document, const GltfOptions& options);

/// The glTF JSON as tinygltf writes it, keys sorted. An empty buffer_uri stands for a GLB's binary
/// chunk and gives the text without white space. Text that is not UTF-8 and non-finite numbers
/// become U+FFFD and null.
[[nodiscard]] std::string gltf_json(const GltfDocument& document, const GltfOptions& options,
                                    std::string_view buffer_uri);

/// Puts the arrays and primitives of a block behind those of `all`: into the last mesh, their bytes
/// behind the buffer's; or as a mesh of its own with a buffer of its own, `uri`.
void append(GltfDocument& all, const GltfDocument& block);
void append_mesh(GltfDocument& all, const GltfDocument& block, std::string uri);

/// A file name as a relative URI: all but letters, digits and -._~ percent-encoded.
[[nodiscard]] std::string encode_uri(std::string_view file_name);

}  // namespace planish
