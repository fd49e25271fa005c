#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/shared/ordered_stream.h"

namespace planish {

/// A glTF on its way into a file: its JSON, and what writes the buffer that this names. An asset's
/// begins with what it keeps (asset/write_asset.h), any other with nothing (plain_document()).
struct GltfDocument {
  /// Of a list, the places that new elements take: those that are free, then those behind it.
  struct Places {
    std::set<std::int64_t> free;
    std::int64_t next(nlohmann::json& list);
  };

  nlohmann::json json = nlohmann::json::object();
  Places accessors, views;
  std::set<std::string> extensions;         ///< required of readers by the surfaces in it
  std::vector<std::uint64_t> full_buffers;  ///< bytes of each before the last one
  std::uint64_t buffer_bytes = 0;           ///< of the last, so far
  std::uint64_t decoded_bytes = 0;          ///< of the buffer that streams stand for
  std::uint64_t vertex_count = 0, triangle_count = 0;  ///< of all surfaces
  /// Write the parts of the only buffer, in order, each padded to a multiple of four.
  std::vector<std::function<void(std::span<const ByteSink>)>> parts;

  /// Puts bytes, which must outlive it, behind the others. Returns where in the buffer.
  std::uint64_t keep(std::span<const std::byte> bytes);
  /// The same with a buffer view, whose number it returns.
  std::int64_t add_view(std::span<const std::byte> bytes);
  /// Accessors and buffer views of a surface, whose bytes come behind the others: whoever adds it
  /// adds that part. Returns the accessor of each array.
  std::vector<std::int64_t> add(const GltfPayload& payload);
  /// Sets its buffers. The text, keys sorted, with URIs for the buffers of a .gltf at that path, or
  /// with an empty one for the chunk of a GLB, without white space. Text that is not UTF-8 and
  /// non-finite numbers become U+FFFD and null.
  [[nodiscard]] std::string text(const std::filesystem::path& gltf);
};

/// "asset" with the options' extras, which also say what packing has done.
[[nodiscard]] nlohmann::json asset_json(const GltfOptions& options);

/// `rest` with attributes, morph targets and indices of a primitive, whose arrays have these
/// accessors.
[[nodiscard]] nlohmann::json primitive_json(const GltfPrimitive& primitive,
                                            std::span<const std::int64_t> accessors,
                                            nlohmann::json rest);

/// A document of surfaces alone: a node and a mesh for each, of several in a buffer of its own, and
/// plain materials.
[[nodiscard]] GltfDocument plain_document(std::span<const GltfPayload> surfaces,
                                          const GltfOptions& options);

/// Writes a .glb, or a .gltf and its buffer, by extension. The buffer comes first: the document is
/// nothing without it. Warns of large ones; reports "write" as done. Throws
/// Error{UnwritableOutput}; for a .glb Error{InvalidArgument} from 4 GiB on.
GltfFile write_document(const std::filesystem::path& path, GltfDocument document,
                        const GltfOptions& options);
/// The same as a GLB in memory.
[[nodiscard]] std::vector<std::byte> encode_document(GltfDocument document,
                                                     const GltfOptions& options);

/// The text of a document, or what stands before a GLB's buffer; GltfOptions::observe gets it too.
void write_text(OutputFile& file, std::string_view text, const GltfOptions& options);

/// Bytes in pieces, and zeros up to a multiple of four.
void write_padded(std::span<const std::byte> bytes, std::span<const ByteSink> sinks);

/// Bytes of the GLB of a JSON text (before padding) and a buffer.
/// Throws Error{InvalidArgument} naming `name` where they do not fit a GLB's 32-bit length.
[[nodiscard]] std::uint64_t glb_byte_count(std::uint64_t json_bytes, std::uint64_t buffer_bytes,
                                           std::string_view name);

/// A file name as a relative URI: all but letters, digits and -._~ percent-encoded.
[[nodiscard]] std::string encode_uri(std::string_view file_name);

}  // namespace planish
