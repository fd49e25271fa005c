#include "planish/files/gltf/gltf_payload.h"

#include <algorithm>
#include <memory>

#include "planish/core/host_scope.h"
#include "planish/files/gltf/gltf_blocks.h"
#include "planish/files/gltf/gltf_buffer.h"
#include "planish/files/gltf/gltf_checks.h"
#include "planish/files/gltf/gltf_layout.h"
#include "planish/files/gltf/gltf_packing.h"
#include "planish/files/gltf/gltf_survey.h"
#include "planish/files/gltf/position_grid.h"

namespace planish {
namespace {

GltfLayout whole_layout(const SurfaceBlocks& surface, const GltfVertices& vertices,
                        const GltfOptions& options) {
  require_numbers(surface, options);
  return gltf_layout(surface, vertices, options);
}

// In memory first, since packing needs all of it.
PackedGltf pack_at_once(const SurfaceBlocks& surface, const GltfOptions& given) {
  GltfOptions options = given;
  options.callbacks = share_of(given.callbacks, 0, 0.5);
  const GltfVertices vertices = gltf_vertices(surface, options);
  const GltfLayout layout = whole_layout(surface, vertices, options);
  GltfContents plain{plain_document(layout, gltf_bounds(surface, vertices, options), options), {}};
  plain.buffer.reserve(layout.buffer_bytes);
  const ByteSink append = [&](std::span<const std::byte> piece) {
    plain.buffer.insert(plain.buffer.end(), piece.begin(), piece.end());
  };
  write_buffer(surface, vertices, options, std::span(&append, 1));
  const GltfBounds bounds = bounds_of_all(plain.document);
  tell_kept_float(options, bounds);
  GltfContents packed = pack_gltf(plain, vertices, options, bounds);
  PackedGltf all{std::move(packed.document), {}, layout.vertex_count};
  all.pieces.push_back(std::move(packed.buffer));
  return all;
}

GltfPayload packed_payload(const SurfaceBlocks& surface, const GltfOptions& options) {
  require_numbers(surface, options);
  const bool is_small = surface.info().face_count <= kPackedFaces;
  const auto packed = std::make_shared<const PackedGltf>(
      is_small ? pack_at_once(surface, options) : pack_by_blocks(surface, options));
  GltfPayload contents;
  contents.document = packed->document;
  contents.vertex_count = packed->vertex_count;
  contents.triangle_count =
      static_cast<std::uint64_t>(surface.info().corner_count - 2 * surface.info().face_count);
  contents.write_buffer = [packed](std::span<const ByteSink> sinks) {
    constexpr std::size_t kPiece = std::size_t{1} << 20;
    for (const RawVector<std::byte>& piece : packed->pieces) {
      const std::span<const std::byte> bytes = piece;
      for (std::size_t at = 0; at < bytes.size(); at += kPiece)
        for (const ByteSink& sink : sinks)
          sink(bytes.subspan(at, std::min(kPiece, bytes.size() - at)));
    }
  };
  return contents;
}

}  // namespace

GltfPayload payload_of(const SurfaceBlocks& surface, const GltfOptions& options, bool is_glb) {
  require_a_face(surface.info().face_count, options);
  if (options.compression != GltfCompression::None) return packed_payload(surface, options);
  auto vertices = std::make_shared<const GltfVertices>(gltf_vertices(surface, options));
  const GltfLayout layout = whole_layout(surface, *vertices, options);
  // Before the work: it may not fit.
  if (is_glb) (void)glb_byte_count(0, layout.buffer_bytes, options.name);
  GltfPayload contents;
  contents.vertex_count = layout.vertex_count;
  contents.triangle_count = layout.triangle_count;
  contents.document = plain_document(layout, gltf_bounds(surface, *vertices, options), options);
  contents.write_buffer = [&surface, &options, vertices](std::span<const ByteSink> sinks) {
    write_buffer(surface, *vertices, options, sinks);
  };
  return contents;
}

std::string payload_json(const GltfPayload& contents, const GltfOptions& options,
                         std::string_view uri) {
  if (options.compression != GltfCompression::Meshopt)
    return gltf_json(contents.document, options, uri);
  GltfOptions reordered = options;
  reordered.extras.emplace_back("vertex_order", "as triangles first use them");
  return gltf_json(contents.document, reordered, uri);
}

}  // namespace planish
