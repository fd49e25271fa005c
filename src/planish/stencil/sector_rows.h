#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace planish {

/// The output vertices of a tessellation. A vertex between sharp edges has a normal for each
/// sector of faces: row v < vertex count is vertex v in its first sector; the further sectors
/// follow in rows of their own.
class SectorRows {
 public:
  struct Place {
    std::int32_t vertex, sector;
  };

  SectorRows() = default;
  /// `extra` holds the sectors from 1 on, ascending by vertex, then sector, none left out.
  SectorRows(std::int64_t vertex_count, std::vector<Place> extra)
      : vertex_count_(vertex_count), extra_(std::move(extra)) {}

  [[nodiscard]] std::int64_t count() const {
    return vertex_count_ + static_cast<std::int64_t>(extra_.size());
  }
  [[nodiscard]] Place place(std::int64_t row) const {
    return row < vertex_count_ ? Place{static_cast<std::int32_t>(row), 0}
                               : extra_[row - vertex_count_];
  }
  /// Whether the vertex has more than one row.
  [[nodiscard]] bool is_split(std::int32_t vertex) const {
    const auto first = first_extra(vertex);
    return first != extra_.end() && first->vertex == vertex;
  }
  [[nodiscard]] std::int32_t row(std::int32_t vertex, std::int32_t sector) const {
    if (sector == 0) return vertex;
    return static_cast<std::int32_t>(vertex_count_ + (first_extra(vertex) - extra_.begin()) +
                                     sector - 1);
  }

 private:
  [[nodiscard]] std::vector<Place>::const_iterator first_extra(std::int32_t vertex) const {
    return std::lower_bound(extra_.begin(), extra_.end(), vertex,
                            [](const Place& place, std::int32_t v) { return place.vertex < v; });
  }

  std::int64_t vertex_count_ = 0;
  std::vector<Place> extra_;
};

}  // namespace planish
