#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/solve/stencil_table.h"

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

/// One row being gathered: sources may be added several times and in any order.
class StencilRow {
 public:
  struct Entry {
    std::int32_t index;
    double weight, du, dv;
  };

  void clear() { count_ = 0; }
  void add(std::int32_t index, double weight, double du = 0, double dv = 0) {
    if (count_ == entries_.size()) entries_.resize(2 * count_);
    entries_[count_++] = {index, weight, du, dv};
  }
  /// Sorts by index and merges what was added several times.
  void finish();
  [[nodiscard]] std::span<const Entry> entries() const { return {entries_.data(), count_}; }

 private:
  std::vector<Entry> entries_ = std::vector<Entry>(64);  // the first count_ are in use
  std::size_t count_ = 0;
};

/// Whether rows carry derivative weights.
enum class Derivatives { No, Yes };

/// `rows` of a table on all threads; the result does not depend on their number.
/// `make_emitter()` is called once per piece of rows and returns a callable
/// emit(row_index, StencilRow&) with its own scratch memory.
/// Throws Error{OutOfMemory} when the entries exceed what 32-bit offsets address.
template <class MakeEmitter>
[[nodiscard]] StencilTable build_rows(std::int32_t source_count, RowRange rows,
                                      Derivatives derivatives, const MakeEmitter& make_emitter);

/// Joins pieces in order. Throws as build_rows.
[[nodiscard]] StencilTable concatenate(std::int32_t source_count,
                                       std::vector<StencilTable>&& pieces);

/// Throws Error{OutOfMemory} where 32-bit offsets do not address so many entries.
void require_entries_fit(std::int64_t entry_count);

/// The rows over points alone, their entries by index. Throws as build_rows.
[[nodiscard]] StencilTable expanded(const SummedView& table);

/// How many entries expanded() has at most, by those of the table.
[[nodiscard]] double expansion(const SummedView& table);

void reserve(StencilTable& rows, std::size_t row_count, std::size_t entry_count,
             Derivatives derivatives);
void append(StencilTable& rows, const StencilRow& row, Derivatives derivatives);

template <class MakeEmitter>
StencilTable build_rows(std::int32_t source_count, RowRange rows, Derivatives derivatives,
                        const MakeEmitter& make_emitter) {
  // Large enough to hide the cost of a piece, small enough to balance uneven rows.
  constexpr std::int64_t kRowsAtOnce = 8192;
  const std::int64_t end_row = rows.first + rows.count;
  std::vector<StencilTable> pieces(
      static_cast<std::size_t>((rows.count + kRowsAtOnce - 1) / kRowsAtOnce));
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    auto emit = make_emitter();
    StencilRow row;
    std::size_t entry_count = 0;  // of the last piece: the next is much like it
    for (std::size_t p = begin; p < end; ++p) {
      const std::int64_t first = rows.first + static_cast<std::int64_t>(p) * kRowsAtOnce;
      reserve(pieces[p], kRowsAtOnce, entry_count, derivatives);
      for (std::int64_t i = first; i < std::min(first + kRowsAtOnce, end_row); ++i) {
        row.clear();
        emit(static_cast<std::int32_t>(i), row);
        row.finish();
        append(pieces[p], row, derivatives);
      }
      entry_count = pieces[p].indices.size();
    }
  });
  return concatenate(source_count, std::move(pieces));
}

}  // namespace planish
