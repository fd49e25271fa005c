// Based on: Khronos, "glTF 2.0 Specification", 2021. The container is written here and not by
// tinygltf, which copies the buffer several times and corrupts files above 4 GiB; in the tests
// tinygltf reads our files back.
#include "planish/files/gltf/write_gltf.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/files/gltf/gltf_buffer.h"
#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/stored_position.h"

namespace planish {
namespace {

constexpr std::uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr std::uint32_t kGlbVersion = 2;

// Many readers keep sizes in signed 32-bit numbers.
constexpr std::uint64_t kLargeFileBytes = std::uint64_t{1} << 31;

template <std::size_t N>
void send(const ByteSink& sink, const std::array<std::uint32_t, N>& words) {
  sink(std::as_bytes(std::span(words)));
}

std::string padded_json(const SurfaceMesh& surface, const GltfLayout& layout,
                        const GltfOptions& options) {
  std::string json = gltf_json(layout, gltf_bounds(surface, options), options, {});
  json.resize((json.size() + 3) / 4 * 4, ' ');
  return json;
}

void write_glb(const SurfaceMesh& surface, const GltfVertices& vertices, const GltfOptions& options,
               const std::string& json, const ByteSink& sink) {
  const std::uint64_t buffer_bytes = gltf_layout(surface, vertices).buffer_bytes;
  const auto all =
      static_cast<std::uint32_t>(glb_byte_count(json.size(), buffer_bytes, options.name));
  send(sink, std::array{kGlbMagic, kGlbVersion, all});
  send(sink, std::array{static_cast<std::uint32_t>(json.size()), kJsonChunk});
  sink(std::as_bytes(std::span(json)));
  send(sink, std::array{static_cast<std::uint32_t>(buffer_bytes), kBinaryChunk});
  write_buffer(surface, vertices, options, sink);
}

void warn_if_large(std::uint64_t bytes, const GltfOptions& options) {
  if (bytes <= kLargeFileBytes) return;
  options.callbacks.warn({"large-file", options.name + ": " + std::to_string(bytes) +
                                            " bytes; many programs cannot open a glTF file above "
                                            "2 GiB, fewer levels make it smaller"});
}

}  // namespace

std::vector<std::byte> encode_glb(const SurfaceMesh& surface, const GltfOptions& options) {
  require_writable(surface, options);
  const GltfVertices vertices = gltf_vertices(surface);
  const GltfLayout layout = gltf_layout(surface, vertices);
  const std::string json = padded_json(surface, layout, options);
  const std::uint64_t bytes = glb_byte_count(json.size(), layout.buffer_bytes, options.name);
  warn_if_large(bytes, options);
  std::vector<std::byte> glb;
  glb.reserve(bytes);
  write_glb(surface, vertices, options, json, [&](std::span<const std::byte> piece) {
    glb.insert(glb.end(), piece.begin(), piece.end());
  });
  return glb;
}

GltfFile write_gltf(const std::filesystem::path& path, const SurfaceMesh& surface,
                    const GltfOptions& options) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".glb" && extension != ".gltf") {
    throw Error(ErrorCode::InvalidArgument,
                path.string() + ": extension is neither .glb nor .gltf");
  }
  require_writable(surface, options);
  const GltfVertices vertices = gltf_vertices(surface);
  const GltfLayout layout = gltf_layout(surface, vertices);
  GltfFile written{0, layout.vertex_count, layout.triangle_count};
  if (extension == ".glb") {
    const std::string json = padded_json(surface, layout, options);
    written.byte_count = glb_byte_count(json.size(), layout.buffer_bytes, path.string());
    warn_if_large(written.byte_count, options);
    OutputFile file(path);
    write_glb(surface, vertices, options, json, [&](auto bytes) { file.write(bytes); });
    file.commit();
    return written;
  }
  const std::filesystem::path buffer_path = std::filesystem::path(path).replace_extension(".bin");
  const std::string json = gltf_json(layout, gltf_bounds(surface, options), options,
                                     encode_uri(buffer_path.filename().string()));
  written.byte_count = json.size() + layout.buffer_bytes;
  warn_if_large(layout.buffer_bytes, options);
  OutputFile file(path), buffer(buffer_path);
  write_buffer(surface, vertices, options, [&](auto bytes) { buffer.write(bytes); });
  file.write(json);
  // The JSON is nothing without the buffer that it names.
  buffer.commit();
  file.commit();
  return written;
}

std::vector<glm::dvec3> written_positions(const SurfaceMesh& surface, const GltfOptions& options,
                                          std::size_t count) {
  constexpr std::size_t kGrain = std::size_t{1} << 13;
  const StoredPosition stored(options);
  std::vector<glm::dvec3> written(std::min(count, surface.positions.size()));
  parallel_for(written.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      written[i] = stored.load(stored.store(surface.positions[i]));
    }
  });
  return written;
}

}  // namespace planish
