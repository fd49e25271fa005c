// Based on: Khronos, "glTF 2.0 Specification", 2021. tinygltf writes the document
// (gltf_document.h), the container is written here: tinygltf copies the buffer several times and
// corrupts files above 4 GiB.
#include "planish/files/gltf/write_gltf.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <memory>

#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/visible_text.h"
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

// In memory first, since packing needs all of it.
void pack(Contents& contents, const GltfVertices& vertices, const GltfOptions& options) {
  GltfContents plain{contents.document, {}};
  plain.buffer.reserve(contents.document.buffer_bytes);
  const ByteSink append = [&](std::span<const std::byte> piece) {
    plain.buffer.insert(plain.buffer.end(), piece.begin(), piece.end());
  };
  contents.write_buffer(std::span(&append, 1));
  auto packed = std::make_shared<GltfContents>(pack_gltf(plain, vertices, options));
  contents.document = packed->document;
  contents.write_buffer = [packed](std::span<const ByteSink> sinks) {
    constexpr std::size_t kPiece = std::size_t{1} << 20;
    const std::span<const std::byte> bytes = packed->buffer;
    for (std::size_t at = 0; at < bytes.size(); at += kPiece)
      send(sinks, bytes.subspan(at, std::min(kPiece, bytes.size() - at)));
  };
}

Contents contents_of(const SurfaceBlocks& surface, const GltfOptions& options, bool is_glb) {
  require_fields(surface.info().row_count, options);
  auto vertices = std::make_shared<const GltfVertices>(gltf_vertices(surface));
  const GltfLayout layout = gltf_layout(surface, *vertices, options);
  const bool is_packed = options.compression != GltfCompression::None;
  // Before the work: it may not fit.
  if (is_glb && !is_packed) (void)glb_byte_count(0, layout.buffer_bytes, options.name);
  Contents contents;
  contents.vertex_count = layout.vertex_count;
  contents.triangle_count = layout.triangle_count;
  contents.document = plain_document(layout, gltf_bounds(surface, *vertices, options), options);
  contents.write_buffer = [&surface, &options, vertices](std::span<const ByteSink> sinks) {
    write_buffer(surface, *vertices, options, sinks);
  };
  if (is_packed) pack(contents, *vertices, options);
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
  glb.write(sinks_to(file, glb.options));
  file.commit();
}

// The document and its buffer; the byte count of both.
std::uint64_t write_pair(const std::filesystem::path& path, const Contents& contents,
                         const GltfOptions& options) {
  const std::filesystem::path buffer_path = std::filesystem::path(path).replace_extension(".bin");
  const std::string json = json_of(contents, options, encode_uri(buffer_path.filename().string()));
  warn_if_large(contents.document.buffer_bytes, options);
  OutputFile file(path), buffer(buffer_path);
  const ByteSink to_buffer = [&](std::span<const std::byte> bytes) { buffer.write(bytes); };
  contents.write_buffer(std::span(&to_buffer, 1));
  send(sinks_to(file, options), std::as_bytes(std::span(json)));
  // The JSON is nothing without the buffer that it names.
  buffer.commit();
  file.commit();
  return json.size() + contents.document.buffer_bytes;
}

}  // namespace

std::vector<std::byte> encode_glb(const SurfaceBlocks& surface, const GltfOptions& options) {
  const Glb glb(surface, options);
  std::vector<std::byte> bytes;
  bytes.reserve(glb.byte_count);
  const ByteSink append = [&](std::span<const std::byte> piece) {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
  };
  glb.write(std::span(&append, 1));
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
  if (extension == ".glb") {
    const Glb glb(surface, options);
    write_glb(path, glb);
    return {glb.byte_count, glb.contents.vertex_count, glb.contents.triangle_count};
  }
  const Contents contents = contents_of(surface, options, false);
  return {write_pair(path, contents, options), contents.vertex_count, contents.triangle_count};
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
