#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/json_place.h"

namespace planish {

/// Binary data of a glTF document, fetched when first asked for: a GLB's chunk, data URIs, and
/// files beside the document where `folder` is given.
class GltfSource {
 public:
  GltfSource(JsonPlace root, std::span<const std::byte> glb_chunk,
             std::optional<std::filesystem::path> folder)
      : root_(std::move(root)), glb_chunk_(glb_chunk), folder_(std::move(folder)) {}

  /// The bytes of buffer `index`: exactly its byteLength. Throws Error{UnreadableInput}.
  [[nodiscard]] std::span<const std::byte> buffer(std::int64_t index);
  /// The bytes of a buffer view, which lie within its buffer; unpacked where they are packed.
  [[nodiscard]] std::span<const std::byte> view(std::int64_t index);
  /// The bytes that a URI stands for: data, or a file beside the document.
  [[nodiscard]] std::span<const std::byte> fetch(const JsonPlace& uri);
  /// True the first time that it is asked of an accessor: what is looked at once for all its uses.
  [[nodiscard]] bool is_new_sparse(std::int64_t accessor) {
    return sparse_accessors_.insert(accessor).second;
  }

 private:
  // Of a buffer view, or of its packed stream.
  [[nodiscard]] std::span<const std::byte> part(const JsonPlace& place);

  JsonPlace root_;
  std::span<const std::byte> glb_chunk_;
  std::optional<std::filesystem::path> folder_;
  std::map<std::string, RawVector<std::byte>> fetched_;    // by URI, so that none is read twice
  std::map<std::int64_t, RawVector<std::byte>> unpacked_;  // by buffer view
  std::set<std::int64_t> sparse_accessors_;
};

/// Decodes base64 (RFC 4648) with or without its padding; empty if `text` is none.
[[nodiscard]] std::optional<std::vector<std::byte>> decode_base64(std::string_view text);

/// The file name that a relative URI stands for; empty where it is absolute, has a scheme, leads
/// to a parent folder or is badly encoded.
[[nodiscard]] std::optional<std::string> decode_relative_uri(std::string_view uri);

}  // namespace planish
