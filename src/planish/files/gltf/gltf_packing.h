#pragma once

#include <cstddef>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/gltf_vertices.h"

namespace planish {

/// The step of the coarsest grid on which every position moves by `error` at most, half a step in
/// each of three directions.
[[nodiscard]] double coarsest_step(double error);

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
/// Calls options.kept_float, if it is there and positions within these bounds stay float32.
void tell_kept_float(const GltfOptions& options, const GltfBounds& bounds);
[[nodiscard]] GltfBounds bounds_of_all(const GltfDocument& document);

}  // namespace planish
