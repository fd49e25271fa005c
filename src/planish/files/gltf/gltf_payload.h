#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/float_box.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/surface/face_range_blocks.h"

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
  std::optional<FloatBox> bounds;       ///< smallest and largest numbers as they are stored
  std::uint64_t offset = 0, bytes = 0;  ///< decoded, where there is a stream
  std::uint32_t stride = 0;             ///< 0: without gaps
  std::optional<GltfStream> stream;
};

/// Triangles by their arrays, and the names of their group, which may be empty.
struct GltfPrimitive {
  std::map<std::string, std::size_t> attributes;
  std::size_t indices = 0;
  std::string name, material;
  std::int32_t group = -1;     ///< of the surface; -1: it has none
  bool encodes_ngons = false;  ///< see GltfOptions::ngon_groups
};

/// A surface on its way into a file: a mesh with its place, and the bytes that its arrays name.
struct GltfPayload {
  std::vector<GltfArray> arrays;
  std::vector<GltfPrimitive> primitives;
  std::uint64_t vertex_count = 0, triangle_count = 0;  ///< of all primitives
  std::uint64_t buffer_bytes = 0;       ///< of all arrays, each padded to a multiple of 4
  std::uint64_t decoded_bytes = 0;      ///< of the buffer that streams stand for; 0: none does
  std::vector<std::string> extensions;  ///< required by readers
  bool shares_materials = false;        ///< primitives of one material's name have it together
  glm::dvec3 translation{0.0};
  double scale = 1.0;
  /// Its buffer, piece by piece, where it has been made already; else write_plain() sends it.
  std::vector<RawVector<std::byte>> pieces;
  std::function<void(std::span<const ByteSink>)> write_plain;

  void write(std::span<const ByteSink> sinks) const;
};

/// Surveys the surface, and packs it where it is to be compressed: a large one by blocks of
/// kPackedFaces, a primitive each (or one for each group), all on one grid. The same bytes for any
/// number of threads. Calls options.decoded. Surface and options must outlive it. Throws as
/// encode_glb(); where `is_glb` before the work, if it cannot fit.
[[nodiscard]] GltfPayload payload_of(const SurfaceBlocks& surface, const GltfOptions& options,
                                     bool is_glb);

/// Some faces of a surface, to be written by themselves.
class GltfBlock {
 public:
  /// `options` are those of the whole; its callbacks are not taken.
  GltfBlock(const SurfaceBlocks& surface, RowRange faces, const GltfOptions& options);
  GltfBlock(const GltfBlock&) = delete;
  GltfBlock& operator=(const GltfBlock&) = delete;

  [[nodiscard]] const FaceRangeBlocks& surface() const { return surface_; }
  [[nodiscard]] const GltfVertices& vertices() const { return vertices_; }
  [[nodiscard]] GltfOptions& options() { return options_; }
  [[nodiscard]] std::uint64_t buffer_bytes() const { return buffer_bytes_; }
  /// Uncompressed; adds the rows whose normals are those of facets. This must outlive it. Throws as
  /// gltf_survey().
  [[nodiscard]] GltfPayload payload(DegenerateRows& degenerate) const;

 private:
  void take_further(GltfAttribute& attribute);

  FaceRangeBlocks surface_;
  GltfVertices vertices_;
  GltfOptions options_;
  std::list<std::vector<float>> values_;  // of options_.attributes
  std::list<std::vector<UvOnRow>> further_;
  std::list<std::vector<glm::dvec2>> uvs_;  // of options_.further_uvs
  std::uint64_t buffer_bytes_ = 0;
};

/// So many faces, from `first` on, that their buffer is no larger than options.buffer_bytes, or
/// one. `surface_bytes`: of all in one buffer.
[[nodiscard]] RowRange faces_of_buffer(const SurfaceBlocks& surface, std::int64_t first,
                                       std::uint64_t surface_bytes, const GltfOptions& options);

}  // namespace planish
