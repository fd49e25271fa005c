#include "planish/files/gltf/write_gltf.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "planish/core/formatted.h"
#include "planish/core/host_scope.h"
#include "planish/core/lower_case.h"
#include "planish/core/memory_size.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/visible_text.h"
#include "planish/files/gltf/gltf_buffer.h"
#include "planish/files/gltf/gltf_checks.h"
#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/gltf_materials.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/stored_position.h"
#include "planish/files/input_files.h"

namespace planish {
namespace {

GltfDocument document_of(const SurfaceBlocks& surface, const GltfOptions& options, bool is_glb) {
  const auto payload = std::make_shared<const GltfPayload>(payload_of(surface, options, is_glb));
  GltfDocument document = plain_document(std::span(payload.get(), 1), options);
  document.parts.emplace_back(
      [payload](std::span<const ByteSink> sinks) { payload->write(sinks); });
  if (options.materials != nullptr) options.materials->apply(document, options.image_folder);
  return document;
}

// A document and buffers of some faces each, one after another.
class SeveralBuffers {
 public:
  SeveralBuffers(const std::filesystem::path& path, const SurfaceBlocks& surface,
                 std::uint64_t surface_bytes, const GltfOptions& options)
      : path_(path), surface_(surface), surface_bytes_(surface_bytes), options_(options) {}

  GltfFile write() {
    OutputFile file(path_);
    const std::int64_t all = surface_.info().face_count;
    DegenerateRows degenerate;
    for (std::int64_t first = 0; first < all;) first += write_block(first, degenerate);
    warn_of(degenerate, options_.callbacks);
    GltfDocument document = plain_document(blocks_, options_);
    const std::string text = document.text(path_);
    write_text(file, text, options_);
    for (const auto& buffer : buffers_) buffer->commit();
    file.commit();
    options_.callbacks.report("write", 1);
    GltfFile written{.byte_count = text.size(),
                     .vertex_count = document.vertex_count,
                     .triangle_count = document.triangle_count,
                     .buffer_count = buffers_.size()};
    for (const GltfPayload& block : blocks_) written.byte_count += block.buffer_bytes;
    return written;
  }

 private:
  // Returns how many faces it has taken.
  std::int64_t write_block(std::int64_t first, DegenerateRows& degenerate) {
    RowRange faces = faces_of_buffer(surface_, first, surface_bytes_, options_);
    auto block = std::make_unique<GltfBlock>(surface_, faces, options_);
    // Where faces that follow one another lie apart, more of their vertices are in two blocks.
    while (block->buffer_bytes() > options_.buffer_bytes && faces.count > 1) {
      faces.count /= 2;
      block = std::make_unique<GltfBlock>(surface_, faces, options_);
    }
    const double done =
        static_cast<double>(first) / static_cast<double>(surface_.info().face_count);
    const double share =
        static_cast<double>(faces.count) / static_cast<double>(surface_.info().face_count);
    block->options().callbacks.progress = share_of(options_.callbacks, done, done + share).progress;
    GltfPayload& payload = blocks_.emplace_back(block->payload(degenerate));
    payload.shares_materials = true;
    OutputFile& buffer = *buffers_.emplace_back(
        std::make_unique<OutputFile>(gltf_buffer_path(path_, buffers_.size())));
    buffer.reserve(payload.buffer_bytes);
    const ByteSink to_buffer = [&](std::span<const std::byte> bytes) { buffer.write(bytes); };
    payload.write(std::span(&to_buffer, 1));
    payload.write_plain = nullptr;  // the block goes
    return faces.count;
  }

  const std::filesystem::path& path_;
  const SurfaceBlocks& surface_;
  std::uint64_t surface_bytes_;
  const GltfOptions& options_;
  std::vector<GltfPayload> blocks_;
  std::vector<std::unique_ptr<OutputFile>> buffers_;
};

// A surface whose seams and groups make copies has more.
std::uint64_t least_buffer_bytes(const SurfaceInfo& info, const GltfOptions& options) {
  GltfVertices vertices;
  vertices.parts = {
      {.vertex_count = info.row_count,
       .uv_sets = info.uv_count > 0 ? 1 + static_cast<int>(options.further_uvs.size()) : 0,
       .triangle_count = static_cast<std::uint64_t>(info.corner_count - 2 * info.face_count)}};
  return plain_payload(info, vertices, options).buffer_bytes;
}

}  // namespace

std::vector<std::byte> encode_glb(const SurfaceBlocks& surface, const GltfOptions& options) {
  const HostScope host(options.callbacks);
  if (options.compression == GltfCompression::None)
    (void)memory_size(least_buffer_bytes(surface.info(), options), options.name);
  return encode_document(document_of(surface, options, true), options);
}

GltfFile write_gltf(const std::filesystem::path& path, const SurfaceBlocks& surface,
                    const GltfOptions& options) {
  const std::string extension = lower_case(path.extension().string());
  if (extension != ".glb" && extension != ".gltf") {
    throw Error(ErrorCode::InvalidArgument,
                visible(path) + ": extension is neither .glb nor .gltf");
  }
  if (options.materials != nullptr) require_apart(options.materials->input, path, *format_of(path));
  const HostScope host(options.callbacks);
  const std::uint64_t bytes = least_buffer_bytes(surface.info(), options);
  const bool is_glb = extension == ".glb";
  if (!is_glb && options.compression == GltfCompression::None && bytes > options.buffer_bytes) {
    require_numbers(surface, options);
    return SeveralBuffers(path, surface, bytes, options).write();
  }
  return write_document(path, document_of(surface, options, is_glb), options);
}

std::filesystem::path gltf_buffer_path(const std::filesystem::path& document, std::size_t index) {
  std::filesystem::path path = document;
  if (index == 0) return path.replace_extension(".bin");
  return path.replace_filename(formatted("{}-{}.bin", document.stem().string(), index + 1));
}

std::vector<std::byte> encode_glb(const SurfaceMesh& surface, const GltfOptions& options) {
  require_writable(surface, options);
  return encode_glb(*blocks_of(surface, {}), options);
}

GltfFile write_gltf(const std::filesystem::path& path, const SurfaceMesh& surface,
                    const GltfOptions& options) {
  require_writable(surface, options);
  return write_gltf(path, *blocks_of(surface, {}), options);
}

void written_positions(const SurfaceBlocks& surface, const GltfOptions& options, RowRange rows,
                       std::span<glm::dvec3> positions) {
  const StoredPosition stored(options);
  std::vector<glm::vec3> made(positions.size());
  RowTarget target;
  target.stored = made;
  target.origin = options.origin;
  (void)surface.rows(rows, target);
  for (std::size_t i = 0; i < made.size(); ++i) positions[i] = stored.load(stored.turn(made[i]));
}

std::vector<glm::dvec3> written_positions(const SurfaceMesh& surface, const GltfOptions& options,
                                          std::size_t count) {
  std::vector<glm::dvec3> written(std::min(count, surface.positions.size()));
  written_positions(*blocks_of(surface, {}), options,
                    {0, static_cast<std::int64_t>(written.size())}, written);
  return written;
}

}  // namespace planish
