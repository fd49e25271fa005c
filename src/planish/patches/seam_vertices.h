#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace planish {

/// Vertices of a file, where each has one texture coordinate: the first that comes to a row is its
/// own, every other gets a vertex of its own behind all that there are.
class SeamVertices {
 public:
  /// `uvs`: the texture coordinate of each vertex, -1 where none has come yet; grows.
  explicit SeamVertices(std::vector<std::int32_t>& uvs) : uvs_(uvs) {}

  /// The vertex of a corner of a face; `first` is that of its row.
  std::int64_t of_corner(std::int64_t first, std::int32_t row, std::int32_t uv) {
    std::int32_t& own = uvs_[first];
    if (own < 0) own = uv;
    if (own == uv) return first;
    const std::uint64_t key =
        static_cast<std::uint64_t>(row) << 32 | static_cast<std::uint32_t>(uv);
    const auto [entry, is_new] = copies_.try_emplace(key, std::ssize(uvs_));
    if (is_new) uvs_.push_back(uv);
    return entry->second;
  }

  /// Primitives share no vertices.
  void next_primitive() { copies_.clear(); }

 private:
  std::vector<std::int32_t>& uvs_;
  std::unordered_map<std::uint64_t, std::int64_t> copies_;
};

}  // namespace planish
