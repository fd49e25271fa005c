#pragma once

#include <span>

#include "planish/files/gltf/gltf_layout.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/shared/ordered_stream.h"

namespace planish {

/// The layout of a surface.
[[nodiscard]] GltfLayout gltf_layout(const SurfaceBlocks& surface, const GltfVertices& vertices,
                                     const GltfOptions& options);

/// Sends the binary buffer of gltf_layout() to the sinks in pieces of about a MB, in order, the
/// survey being done.
/// Throws Error{Cancelled} and whatever a sink throws.
void write_buffer(const SurfaceBlocks& surface, const GltfVertices& vertices,
                  const GltfOptions& options, std::span<const ByteSink> sinks);

}  // namespace planish
