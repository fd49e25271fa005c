// Based on: Khronos, "glTF 2.0 Specification", 2021, section 4 (GLB).
#include "planish/files/gltf/gltf_container.h"

#include <algorithm>
#include <array>

#include "planish/core/formatted.h"
#include "planish/core/memory_size.h"
#include "planish/files/gltf/gltf_layout.h"

namespace planish {
namespace {

constexpr std::uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr std::uint32_t kGlbVersion = 2;

void send(std::span<const ByteSink> sinks, std::span<const std::byte> bytes) {
  for (const ByteSink& sink : sinks) sink(bytes);
}

template <std::size_t N>
void send(std::span<const ByteSink> sinks, const std::array<std::uint32_t, N>& words) {
  send(sinks, std::as_bytes(std::span(words)));
}

void warn_if_large(std::uint64_t bytes, const GltfOptions& options) {
  if (bytes <= options.large_bytes) return;
  options.callbacks.warn(
      {"large-file", formatted("{}: {} bytes; many programs cannot open a glTF file as large as "
                               "this, fewer levels make it smaller",
                               options.name, bytes)});
}

std::vector<ByteSink> sinks_to(OutputFile& file, const GltfOptions& options) {
  std::vector<ByteSink> sinks{[&file](std::span<const std::byte> bytes) { file.write(bytes); }};
  if (options.observe) sinks.push_back(options.observe);
  return sinks;
}

// A GLB with all that stands before its buffer.
struct Glb {
  Glb(const GltfWhole& of, const GltfOptions& options) : whole(of), json(of.json) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    byte_count = glb_byte_count(json.size(), whole.buffer_bytes, options.name);
    warn_if_large(byte_count, options);
  }

  void write(std::span<const ByteSink> sinks) const {
    send(sinks, std::array{kGlbMagic, kGlbVersion, static_cast<std::uint32_t>(byte_count)});
    send(sinks, std::array{static_cast<std::uint32_t>(json.size()), kJsonChunk});
    send(sinks, std::as_bytes(std::span(json)));
    send(sinks, std::array{static_cast<std::uint32_t>(whole.buffer_bytes), kBinaryChunk});
    whole.write_buffer(sinks);
  }

  const GltfWhole& whole;
  std::string json;
  std::uint64_t byte_count = 0;
};

}  // namespace

void write_padded(std::span<const std::byte> bytes, std::span<const ByteSink> sinks) {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  constexpr std::array<std::byte, 4> kZeros{};
  for (std::size_t at = 0; at < bytes.size(); at += kPiece)
    send(sinks, bytes.subspan(at, std::min(kPiece, bytes.size() - at)));
  if (bytes.size() % 4 != 0) send(sinks, std::span(kZeros).first(4 - bytes.size() % 4));
}

std::vector<std::byte> glb_bytes(const GltfWhole& whole, const GltfOptions& options) {
  const Glb glb(whole, options);
  std::vector<std::byte> bytes;
  bytes.reserve(memory_size(glb.byte_count, options.name));
  const ByteSink append = [&](std::span<const std::byte> piece) {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
  };
  glb.write(std::span(&append, 1));
  return bytes;
}

std::uint64_t write_glb(const std::filesystem::path& path, const GltfWhole& whole,
                        const GltfOptions& options) {
  const Glb glb(whole, options);
  OutputFile file(path);
  file.reserve(glb.byte_count);
  glb.write(sinks_to(file, options));
  file.commit();
  return glb.byte_count;
}

std::uint64_t write_pair(const std::filesystem::path& path, const GltfWhole& whole,
                         const GltfOptions& options) {
  warn_if_large(whole.buffer_bytes, options);
  OutputFile file(path), buffer(gltf_buffer_path(path, 0));
  buffer.reserve(whole.buffer_bytes);
  const ByteSink to_buffer = [&](std::span<const std::byte> bytes) { buffer.write(bytes); };
  whole.write_buffer(std::span(&to_buffer, 1));
  write_observed(file, std::as_bytes(std::span(whole.json)), options);
  buffer.commit();
  file.commit();
  return whole.json.size() + whole.buffer_bytes;
}

void write_observed(OutputFile& file, std::span<const std::byte> bytes,
                    const GltfOptions& options) {
  send(sinks_to(file, options), bytes);
}

}  // namespace planish
