#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// A surface on its way into a file: its document, and what writes the bytes behind that.
struct GltfPayload {
  GltfDocument document;
  std::uint64_t vertex_count = 0, triangle_count = 0;
  std::function<void(std::span<const ByteSink>)> write_buffer;
};

/// Surveys the surface, and packs it where it is to be compressed. Surface and options must outlive
/// it. Throws as encode_glb(); where `is_glb` before the work, if it cannot fit.
[[nodiscard]] GltfPayload payload_of(const SurfaceBlocks& surface, const GltfOptions& options,
                                     bool is_glb);

/// gltf_json(), which says too what packing has done.
[[nodiscard]] std::string payload_json(const GltfPayload& payload, const GltfOptions& options,
                                       std::string_view uri);

}  // namespace planish
