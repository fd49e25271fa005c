// Based on: Khronos, "glTF 2.0 Specification", 2021. tinygltf writes the document
// (gltf_document.h), the container is written here: tinygltf copies the buffer several times and
// corrupts files above 4 GiB.
#include "planish/files/gltf/write_gltf.h"

#include <algorithm>
#include <memory>

#include "planish/core/formatted.h"
#include "planish/core/host_scope.h"
#include "planish/core/lower_case.h"
#include "planish/core/memory_size.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/visible_text.h"
#include "planish/files/gltf/gltf_blocks.h"
#include "planish/files/gltf/gltf_buffer.h"
#include "planish/files/gltf/gltf_checks.h"
#include "planish/files/gltf/gltf_container.h"
#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/gltf_layout.h"
#include "planish/files/gltf/gltf_materials.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/stored_position.h"
#include "planish/files/input_files.h"

namespace planish {
namespace {

// Behind the surface.
void add_images(const GltfMaterials& materials, GltfWhole& whole) {
  whole.buffer_bytes += materials.image_bytes();
  whole.write_buffer = [&materials,
                        surface = std::move(whole.write_buffer)](std::span<const ByteSink> sinks) {
    surface(sinks);
    for (const GltfImage& image : materials.images) write_padded(image.bytes, sinks);
  };
}

// `buffer`: of a .gltf.
GltfWhole whole_of(const SurfaceBlocks& surface, const GltfOptions& options,
                   const std::filesystem::path& buffer) {
  GltfPayload payload = payload_of(surface, options, buffer.empty());
  GltfWhole whole{.json = payload_json(payload, options, encode_uri(buffer.filename().string())),
                  .buffer_bytes = payload.document.buffer_bytes,
                  .vertex_count = payload.vertex_count,
                  .triangle_count = payload.triangle_count,
                  .write_buffer = std::move(payload.write_buffer)};
  if (takes_materials(payload.document, options) && options.image_folder.empty())
    add_images(*options.materials, whole);
  return whole;
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
    document_.shares_materials = true;
    document_.translation = StoredPosition(options_).translation();
    const std::string text = gltf_json(document_, options_, gltf_buffer_path(path_, 0).string());
    write_observed(file, std::as_bytes(std::span(text)), options_);
    for (const auto& buffer : buffers_) buffer->commit();
    file.commit();
    written_.byte_count = text.size() + document_.buffer_bytes;
    written_.buffer_count = buffers_.size();
    return written_;
  }

 private:
  // Returns how many faces it has taken.
  std::int64_t write_block(std::int64_t first, DegenerateRows& degenerate) {
    RowRange faces = faces_of_buffer(surface_, first, surface_bytes_, options_);
    auto block = std::make_unique<GltfBlock>(surface_, faces, options_);
    // Where faces that follow one another lie apart, more of their vertices are in two blocks.
    while (block->layout().buffer_bytes > options_.buffer_bytes && faces.count > 1) {
      faces.count /= 2;
      block = std::make_unique<GltfBlock>(surface_, faces, options_);
    }
    const double done =
        static_cast<double>(first) / static_cast<double>(surface_.info().face_count);
    const double share =
        static_cast<double>(faces.count) / static_cast<double>(surface_.info().face_count);
    block->options().callbacks.progress = share_of(options_.callbacks, done, done + share).progress;
    const std::filesystem::path path = gltf_buffer_path(path_, buffers_.size());
    append_mesh(document_, block->document(degenerate), encode_uri(path.filename().string()));
    OutputFile& buffer = *buffers_.emplace_back(std::make_unique<OutputFile>(path));
    buffer.reserve(block->layout().buffer_bytes);
    const ByteSink to_buffer = [&](std::span<const std::byte> bytes) { buffer.write(bytes); };
    write_buffer(block->surface(), block->vertices(), block->options(), std::span(&to_buffer, 1));
    written_.vertex_count += block->layout().vertex_count;
    written_.triangle_count += block->layout().triangle_count;
    return faces.count;
  }

  const std::filesystem::path& path_;
  const SurfaceBlocks& surface_;
  std::uint64_t surface_bytes_;
  const GltfOptions& options_;
  GltfDocument document_;
  GltfFile written_;
  std::vector<std::unique_ptr<OutputFile>> buffers_;
};

// A surface whose seams and groups make copies has more.
std::uint64_t least_buffer_bytes(const SurfaceInfo& info, const GltfOptions& options) {
  GltfLayout layout;
  layout.has_colors = info.has_colors;
  layout.attributes = row_attributes(options);
  layout.primitives.push_back(
      {.vertex_count = static_cast<std::uint64_t>(info.row_count),
       .triangle_count = static_cast<std::uint64_t>(info.corner_count - 2 * info.face_count),
       .uv_sets = info.uv_count > 0 ? 1 + static_cast<int>(options.further_uvs.size()) : 0});
  set_sizes(layout);
  return layout.buffer_bytes;
}

}  // namespace

std::vector<std::byte> encode_glb(const SurfaceBlocks& surface, const GltfOptions& options) {
  const HostScope host(options.callbacks);
  if (options.compression == GltfCompression::None)
    (void)memory_size(least_buffer_bytes(surface.info(), options), options.name);
  std::vector<std::byte> bytes = glb_bytes(whole_of(surface, options, {}), options);
  options.callbacks.report("write", 1);
  return bytes;
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
  GltfFile written;
  const auto note = [&](const GltfWhole& whole, bool is_glb) {
    written = {is_glb ? write_glb(path, whole, options) : write_pair(path, whole, options),
               whole.vertex_count, whole.triangle_count, std::size_t{is_glb ? 0U : 1U}};
  };
  if (extension == ".glb") {
    note(whole_of(surface, options, {}), true);
  } else if (options.compression == GltfCompression::None && bytes > options.buffer_bytes) {
    require_numbers(surface, options);
    written = SeveralBuffers(path, surface, bytes, options).write();
  } else {
    note(whole_of(surface, options, gltf_buffer_path(path, 0)), false);
  }
  options.callbacks.report("write", 1);
  return written;
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
