#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/gltf_layout.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/surface/face_range_blocks.h"

namespace planish {

/// Some faces of a surface, to be written by themselves.
class GltfBlock {
 public:
  /// `options` are those of the whole; its callbacks are not taken.
  GltfBlock(const SurfaceBlocks& surface, RowRange faces, const GltfOptions& options);
  GltfBlock(const GltfBlock&) = delete;
  GltfBlock& operator=(const GltfBlock&) = delete;

  [[nodiscard]] const FaceRangeBlocks& surface() const { return surface_; }
  [[nodiscard]] const GltfVertices& vertices() const { return vertices_; }
  [[nodiscard]] const GltfLayout& layout() const { return layout_; }
  [[nodiscard]] GltfOptions& options() { return options_; }
  /// The document of the plain buffer; adds the rows whose normals are those of facets. Throws as
  /// gltf_survey().
  [[nodiscard]] GltfDocument document(DegenerateRows& degenerate) const;

 private:
  void take_further(GltfAttribute& attribute);

  FaceRangeBlocks surface_;
  GltfVertices vertices_;
  GltfOptions options_;
  std::list<std::vector<float>> values_;  // of options_.attributes
  std::list<std::vector<UvOnRow>> further_;
  std::list<std::vector<glm::dvec2>> uvs_;  // of options_.further_uvs
  GltfLayout layout_;
};

/// What a compressed file holds behind its document, one piece after another.
struct PackedGltf {
  GltfDocument document;
  std::vector<RawVector<std::byte>> pieces;
  std::uint64_t vertex_count = 0;
};

/// Packs a surface by blocks of kPackedFaces, a primitive each (or one for each group), all
/// in one mesh on one grid. The same bytes for any number of threads. Calls options.decoded.
/// Throws as gltf_bounds().
[[nodiscard]] PackedGltf pack_by_blocks(const SurfaceBlocks& surface, const GltfOptions& options);

/// So many faces, from `first` on, that their buffer is no larger than options.buffer_bytes, or
/// one.
[[nodiscard]] RowRange faces_of_buffer(const SurfaceBlocks& surface, std::int64_t first,
                                       std::uint64_t surface_bytes, const GltfOptions& options);

}  // namespace planish
