#pragma once

#include <cstddef>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/gltf_vertices.h"

namespace planish {

/// A buffer in memory and the document that describes it.
struct GltfContents {
  GltfDocument document;
  RawVector<std::byte> buffer;
};

/// Packs a plain buffer as options.compression says (see write_gltf.h) and hands the decoded
/// positions to options.decoded. `bounds` are those of all positions that lie on one grid: those of
/// the document's, or of more. The same bytes for any number of threads.
[[nodiscard]] GltfContents pack_gltf(const GltfContents& plain, const GltfVertices& vertices,
                                     const GltfOptions& options, const GltfBounds& bounds);
[[nodiscard]] GltfBounds bounds_of_all(const GltfDocument& document);

}  // namespace planish
