#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "planish/core/output_file.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/shared/ordered_stream.h"

namespace planish {

/// A glTF of one buffer: its document, and what writes the bytes of that.
struct GltfWhole {
  std::string json;
  std::uint64_t buffer_bytes = 0;
  std::uint64_t vertex_count = 0, triangle_count = 0;
  std::function<void(std::span<const ByteSink>)> write_buffer;
};

/// Bytes in pieces, and zeros up to a multiple of four.
void write_padded(std::span<const std::byte> bytes, std::span<const ByteSink> sinks);

/// A GLB in memory. Throws Error{InvalidArgument} from 4 GiB on; large ones are warned of.
[[nodiscard]] std::vector<std::byte> glb_bytes(const GltfWhole& whole, const GltfOptions& options);

/// The same to a file, or a document and its buffer, which comes first: the document is nothing
/// without it. Return how many bytes were written. Throw as above, and Error{UnwritableOutput}.
std::uint64_t write_glb(const std::filesystem::path& path, const GltfWhole& whole,
                        const GltfOptions& options);
std::uint64_t write_pair(const std::filesystem::path& path, const GltfWhole& whole,
                         const GltfOptions& options);

/// Bytes of a document, which GltfOptions::observe gets too.
void write_observed(OutputFile& file, std::span<const std::byte> bytes, const GltfOptions& options);

}  // namespace planish
