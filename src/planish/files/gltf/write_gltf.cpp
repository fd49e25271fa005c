// Based on: Khronos, "glTF 2.0 Specification", 2021. tinygltf writes the document
// (gltf_document.h), the container is written here: tinygltf copies the buffer several times and
// corrupts files above 4 GiB.
#include "planish/files/gltf/write_gltf.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <memory>

#include "planish/core/host_scope.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/visible_text.h"
#include "planish/files/gltf/gltf_blocks.h"
#include "planish/files/gltf/gltf_buffer.h"
#include "planish/files/gltf/gltf_checks.h"
#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/gltf_layout.h"
#include "planish/files/gltf/gltf_packing.h"
#include "planish/files/gltf/stored_position.h"

namespace planish {
namespace {

constexpr std::uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr std::uint32_t kGlbVersion = 2;

// Many readers keep sizes in signed 32-bit numbers.
constexpr std::uint64_t kLargeFileBytes = std::uint64_t{1} << 31;

void send(std::span<const ByteSink> sinks, std::span<const std::byte> bytes) {
  for (const ByteSink& sink : sinks) sink(bytes);
}

template <std::size_t N>
void send(std::span<const ByteSink> sinks, const std::array<std::uint32_t, N>& words) {
  send(sinks, std::as_bytes(std::span(words)));
}

void warn_if_large(std::uint64_t bytes, const GltfOptions& options) {
  if (bytes <= kLargeFileBytes) return;
  options.callbacks.warn({"large-file", options.name + ": " + std::to_string(bytes) +
                                            " bytes; many programs cannot open a glTF file above "
                                            "2 GiB, fewer levels make it smaller"});
}

// What is written behind which document.
struct Contents {
  GltfDocument document;
  std::uint64_t vertex_count = 0, triangle_count = 0;
  std::function<void(std::span<const ByteSink>)> write_buffer;
};

GltfLayout whole_layout(const SurfaceBlocks& surface, const GltfVertices& vertices,
                        const GltfOptions& options) {
  require_fields(surface.info().row_count, options);
  return gltf_layout(surface, vertices, options);
}

// In memory first, since packing needs all of it.
PackedGltf pack_at_once(const SurfaceBlocks& surface, const GltfOptions& given) {
  GltfOptions options = given;
  options.callbacks = share_of(given.callbacks, 0, 0.5);
  const GltfVertices vertices = gltf_vertices(surface);
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

Contents packed_contents(const SurfaceBlocks& surface, const GltfOptions& options) {
  require_fields(surface.info().row_count, options);
  const bool is_small = surface.info().face_count <= kPackedFaces;
  const auto packed = std::make_shared<const PackedGltf>(
      is_small ? pack_at_once(surface, options) : pack_by_blocks(surface, options));
  Contents contents;
  contents.document = packed->document;
  contents.vertex_count = packed->vertex_count;
  contents.triangle_count =
      static_cast<std::uint64_t>(surface.info().corner_count - 2 * surface.info().face_count);
  contents.write_buffer = [packed](std::span<const ByteSink> sinks) {
    constexpr std::size_t kPiece = std::size_t{1} << 20;
    for (const RawVector<std::byte>& piece : packed->pieces) {
      const std::span<const std::byte> bytes = piece;
      for (std::size_t at = 0; at < bytes.size(); at += kPiece)
        send(sinks, bytes.subspan(at, std::min(kPiece, bytes.size() - at)));
    }
  };
  return contents;
}

Contents contents_of(const SurfaceBlocks& surface, const GltfOptions& options, bool is_glb) {
  if (options.compression != GltfCompression::None) return packed_contents(surface, options);
  auto vertices = std::make_shared<const GltfVertices>(gltf_vertices(surface));
  const GltfLayout layout = whole_layout(surface, *vertices, options);
  // Before the work: it may not fit.
  if (is_glb) (void)glb_byte_count(0, layout.buffer_bytes, options.name);
  Contents contents;
  contents.vertex_count = layout.vertex_count;
  contents.triangle_count = layout.triangle_count;
  contents.document = plain_document(layout, gltf_bounds(surface, *vertices, options), options);
  contents.write_buffer = [&surface, &options, vertices](std::span<const ByteSink> sinks) {
    write_buffer(surface, *vertices, options, sinks);
  };
  return contents;
}

std::string json_of(const Contents& contents, const GltfOptions& options, std::string_view uri) {
  if (options.compression != GltfCompression::Meshopt)
    return gltf_json(contents.document, options, uri);
  GltfOptions reordered = options;
  reordered.extras.emplace_back("vertex_order", "as triangles first use them");
  return gltf_json(contents.document, reordered, uri);
}

// A GLB with all that stands before its buffer.
struct Glb {
  Glb(const SurfaceBlocks& surface, const GltfOptions& with)
      : options(with), contents(contents_of(surface, with, true)) {
    json = json_of(contents, options, {});
    json.resize((json.size() + 3) / 4 * 4, ' ');
    byte_count = glb_byte_count(json.size(), contents.document.buffer_bytes, options.name);
    warn_if_large(byte_count, options);
  }

  void write(std::span<const ByteSink> sinks) const {
    send(sinks, std::array{kGlbMagic, kGlbVersion, static_cast<std::uint32_t>(byte_count)});
    send(sinks, std::array{static_cast<std::uint32_t>(json.size()), kJsonChunk});
    send(sinks, std::as_bytes(std::span(json)));
    send(sinks,
         std::array{static_cast<std::uint32_t>(contents.document.buffer_bytes), kBinaryChunk});
    contents.write_buffer(sinks);
  }

  const GltfOptions& options;
  Contents contents;
  std::string json;
  std::uint64_t byte_count = 0;
};

std::vector<ByteSink> sinks_to(OutputFile& file, const GltfOptions& options) {
  std::vector<ByteSink> sinks{[&file](std::span<const std::byte> bytes) { file.write(bytes); }};
  if (options.observe) sinks.push_back(options.observe);
  return sinks;
}

void write_glb(const std::filesystem::path& path, const Glb& glb) {
  OutputFile file(path);
  file.reserve(glb.byte_count);
  glb.write(sinks_to(file, glb.options));
  file.commit();
}

// The document and its buffer.
GltfFile write_pair(const std::filesystem::path& path, const Contents& contents,
                    const GltfOptions& options) {
  const std::filesystem::path buffer_path = gltf_buffer_path(path, 0);
  const std::string json = json_of(contents, options, encode_uri(buffer_path.filename().string()));
  warn_if_large(contents.document.buffer_bytes, options);
  OutputFile file(path), buffer(buffer_path);
  buffer.reserve(contents.document.buffer_bytes);
  const ByteSink to_buffer = [&](std::span<const std::byte> bytes) { buffer.write(bytes); };
  contents.write_buffer(std::span(&to_buffer, 1));
  send(sinks_to(file, options), std::as_bytes(std::span(json)));
  // The JSON is nothing without the buffer that it names.
  buffer.commit();
  file.commit();
  return {json.size() + contents.document.buffer_bytes, contents.vertex_count,
          contents.triangle_count, 1};
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
    const std::string json = gltf_json(document_, options_, gltf_buffer_path(path_, 0).string());
    send(sinks_to(file, options_), std::as_bytes(std::span(json)));
    for (const auto& buffer : buffers_) buffer->commit();
    file.commit();
    written_.byte_count = json.size() + document_.buffer_bytes;
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
  layout.fields.resize(options.fields.size());
  layout.primitives.push_back(
      {.vertex_count = static_cast<std::uint64_t>(info.row_count),
       .triangle_count = static_cast<std::uint64_t>(info.corner_count - 2 * info.face_count),
       .has_uvs = info.uv_count > 0});
  set_sizes(layout);
  return layout.buffer_bytes;
}

}  // namespace

std::vector<std::byte> encode_glb(const SurfaceBlocks& surface, const GltfOptions& options) {
  const HostScope host(options.callbacks);
  const Glb glb(surface, options);
  std::vector<std::byte> bytes;
  bytes.reserve(glb.byte_count);
  const ByteSink append = [&](std::span<const std::byte> piece) {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
  };
  glb.write(std::span(&append, 1));
  options.callbacks.report("write", 1);
  return bytes;
}

GltfFile write_gltf(const std::filesystem::path& path, const SurfaceBlocks& surface,
                    const GltfOptions& options) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".glb" && extension != ".gltf") {
    throw Error(ErrorCode::InvalidArgument,
                visible(path) + ": extension is neither .glb nor .gltf");
  }
  const HostScope host(options.callbacks);
  const std::uint64_t bytes = least_buffer_bytes(surface.info(), options);
  GltfFile written;
  if (extension == ".glb") {
    const Glb glb(surface, options);
    write_glb(path, glb);
    written = {glb.byte_count, glb.contents.vertex_count, glb.contents.triangle_count};
  } else if (options.compression == GltfCompression::None && bytes > options.buffer_bytes) {
    require_fields(surface.info().row_count, options);
    written = SeveralBuffers(path, surface, bytes, options).write();
  } else {
    written = write_pair(path, contents_of(surface, options, false), options);
  }
  options.callbacks.report("write", 1);
  return written;
}

std::filesystem::path gltf_buffer_path(const std::filesystem::path& document, std::size_t index) {
  std::filesystem::path path = document;
  if (index == 0) return path.replace_extension(".bin");
  return path.replace_filename(document.stem().string() + "-" + std::to_string(index + 1) + ".bin");
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
