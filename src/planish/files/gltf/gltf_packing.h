#pragma once

#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/gltf_vertices.h"

namespace planish {

/// Packs a plain payload, whose buffer is its only piece, as options.compression says (see
/// write_gltf.h) and hands the decoded positions to options.decoded. `bounds` are those of all
/// positions that lie on one grid: those of the payload's, or of more. The same bytes for any
/// number of threads.
[[nodiscard]] GltfPayload pack_gltf(GltfPayload plain, const GltfVertices& vertices,
                                    const GltfOptions& options, const FloatBox& bounds);
[[nodiscard]] FloatBox bounds_of_all(const GltfPayload& payload);

}  // namespace planish
