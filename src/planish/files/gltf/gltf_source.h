#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/json_place.h"

namespace planish {

/// Binary data of a glTF document, fetched when first asked for: a GLB's chunk, data URIs, and
/// files that the document names, where `file` has a path.
class GltfSource {
 public:
  GltfSource(JsonPlace root, std::span<const std::byte> glb_chunk, const FileBytes& file)
      : root_(std::move(root)), glb_chunk_(glb_chunk), path_(file.path), reach_(file.reach) {}

  /// The bytes of buffer `index`: exactly its byteLength. Throws Error{UnreadableInput}.
  [[nodiscard]] std::span<const std::byte> buffer(std::int64_t index);
  /// The bytes of a buffer view, which lie within its buffer; unpacked where they are packed.
  [[nodiscard]] std::span<const std::byte> view(std::int64_t index);
  /// The bytes that a URI stands for: data, or a file as read_named() gives it.
  [[nodiscard]] std::span<const std::byte> fetch(const JsonPlace& uri);
  /// True the first time that it is asked of an accessor: what is looked at once for all its uses.
  [[nodiscard]] bool is_new_sparse(std::int64_t accessor) {
    return sparse_accessors_.insert(accessor).second;
  }

 private:
  // Of a file the first bytes, as many as are wanted; empty: all, which are not too many.
  [[nodiscard]] std::span<const std::byte> fetch(const JsonPlace& uri,
                                                 std::optional<std::uint64_t> wanted);
  // Of a data URI.
  [[nodiscard]] std::span<const std::byte> decoded(const JsonPlace& uri);
  // Of a buffer view, or of its packed stream.
  [[nodiscard]] std::span<const std::byte> part(const JsonPlace& place);

  JsonPlace root_;
  std::span<const std::byte> glb_chunk_;
  std::filesystem::path path_;
  FileReach reach_;
  // By URI, and of files by what was wanted of them, so that none is read twice.
  std::map<std::string, RawVector<std::byte>> decoded_;
  std::map<std::pair<std::string, std::optional<std::uint64_t>>, RawVector<std::byte>> files_;
  std::map<std::int64_t, RawVector<std::byte>> unpacked_;  // by buffer view
  std::set<std::int64_t> sparse_accessors_;
};

/// Decodes base64 (RFC 4648) with or without its padding; empty if `text` is none.
[[nodiscard]] std::optional<std::vector<std::byte>> decode_base64(std::string_view text);

/// Text with what its percent signs stand for; one that two hexadecimal digits do not follow stands
/// for itself, as in names that no program has encoded.
[[nodiscard]] std::string decode_percents(std::string_view text);

[[nodiscard]] inline bool is_data_uri(std::string_view uri) { return uri.starts_with("data:"); }
/// The bytes of a data URI (RFC 2397), base64 or percent-encoded; empty if it is none.
[[nodiscard]] std::optional<std::vector<std::byte>> decode_data_uri(std::string_view uri);

/// The path that a URI without a scheme stands for, with slashes for backslashes; empty where it
/// has one or names nothing.
[[nodiscard]] std::optional<std::string> decode_uri_path(std::string_view uri);

/// All files that the glTF at `path` names, there or not. Of a file that is none: nothing.
[[nodiscard]] std::vector<std::filesystem::path> gltf_named_files(
    const std::filesystem::path& path);

}  // namespace planish
