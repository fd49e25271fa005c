#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/gltf/write_gltf.h"

namespace planish {

/// Takes the next bytes of a file.
using ByteSink = std::function<void(std::span<const std::byte>)>;

/// Throws Error{InvalidArgument} where the surface cannot be written; see encode_glb.
void require_writable(const SurfaceMesh& surface, const GltfOptions& options);

/// The layout of a surface that is writable.
[[nodiscard]] GltfLayout gltf_layout(const SurfaceMesh& surface, const GltfVertices& vertices);

/// Smallest and largest float32 coordinates as stored.
[[nodiscard]] GltfBounds gltf_bounds(const SurfaceMesh& surface, const GltfOptions& options);

/// Sends the binary buffer of gltf_layout() to `sink` in pieces of a few MB, in order.
/// Throws Error{Cancelled} and whatever `sink` throws.
void write_buffer(const SurfaceMesh& surface, const GltfVertices& vertices,
                  const GltfOptions& options, const ByteSink& sink);

}  // namespace planish
