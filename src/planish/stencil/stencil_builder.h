#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/stencil/stencil_table.h"

namespace planish {

/// A range of rows of a table.
struct RowRange {
  std::int64_t first, count;
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

/// Rows [first, first + count) on all threads; the result does not depend on their number.
/// `make_emitter()` is called once per piece of rows and returns a callable
/// emit(row_index, StencilRow&) with its own scratch memory.
/// Throws Error{OutOfMemory} when the entries exceed what 32-bit offsets address.
template <class MakeEmitter>
[[nodiscard]] StencilRows<double> build_rows(std::int64_t first, std::int64_t count,
                                             Derivatives derivatives,
                                             const MakeEmitter& make_emitter);

/// Joins pieces in order. Throws as build_rows.
[[nodiscard]] StencilRows<double> concatenate(std::vector<StencilRows<double>>&& pieces);

void reserve(StencilRows<double>& rows, std::size_t row_count, std::size_t entry_count,
             Derivatives derivatives);
void append(StencilRows<double>& rows, const StencilRow& row, Derivatives derivatives);

template <class MakeEmitter>
StencilRows<double> build_rows(std::int64_t first, std::int64_t count, Derivatives derivatives,
                               const MakeEmitter& make_emitter) {
  // Large enough to hide the cost of a piece, small enough to balance uneven rows.
  constexpr std::int64_t kPieceRows = 8192;
  const std::int64_t piece_count = (count + kPieceRows - 1) / kPieceRows;
  std::vector<StencilRows<double>> pieces(static_cast<std::size_t>(piece_count));
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    auto emit = make_emitter();
    StencilRow row;
    std::size_t entry_count = 0;  // of the last piece: the next is much like it
    for (std::size_t p = begin; p < end; ++p) {
      const std::int64_t piece_first = first + static_cast<std::int64_t>(p) * kPieceRows;
      const std::int64_t piece_end = std::min(piece_first + kPieceRows, first + count);
      reserve(pieces[p], kPieceRows, entry_count, derivatives);
      for (std::int64_t i = piece_first; i < piece_end; ++i) {
        row.clear();
        emit(static_cast<std::int32_t>(i), row);
        row.finish();
        append(pieces[p], row, derivatives);
      }
      entry_count = pieces[p].indices.size();
    }
  });
  return concatenate(std::move(pieces));
}

}  // namespace planish
