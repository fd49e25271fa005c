#include "planish/stencil/stencil_builder.h"

#include <limits>
#include <string>

#include "planish/core/error.h"

namespace planish {

void StencilRow::finish() {
  const auto out_of_order = [](const Entry& a, const Entry& b) { return a.index >= b.index; };
  if (std::ranges::adjacent_find(entries(), out_of_order) == entries().end()) return;
  const auto by_index = [](const Entry& a, const Entry& b) { return a.index < b.index; };
  // Rows are short as a rule, and nearly sorted: insertion beats std::sort there. Equal indices
  // keep their order either way, so that sums do not depend on the path taken.
  constexpr std::size_t kShortRow = 32;
  if (count_ <= kShortRow) {
    for (std::size_t i = 1; i < count_; ++i) {
      const Entry entry = entries_[i];
      std::size_t j = i;
      for (; j > 0 && entry.index < entries_[j - 1].index; --j) entries_[j] = entries_[j - 1];
      entries_[j] = entry;
    }
  } else {
    std::stable_sort(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(count_),
                     by_index);
  }
  std::size_t last = 0;
  for (std::size_t i = 1; i < count_; ++i) {
    if (entries_[i].index == entries_[last].index) {
      entries_[last].weight += entries_[i].weight;
      entries_[last].du += entries_[i].du;
      entries_[last].dv += entries_[i].dv;
    } else {
      entries_[++last] = entries_[i];
    }
  }
  count_ = last + 1;
}

void reserve(StencilRows<double>& rows, std::size_t row_count, std::size_t entry_count,
             Derivatives derivatives) {
  rows.sizes.reserve(row_count);
  rows.indices.reserve(entry_count);
  rows.weights.reserve(entry_count);
  if (derivatives == Derivatives::No) return;
  rows.du_weights.reserve(entry_count);
  rows.dv_weights.reserve(entry_count);
}

void append(StencilRows<double>& rows, const StencilRow& row, Derivatives derivatives) {
  rows.sizes.push_back(static_cast<std::int32_t>(row.entries().size()));
  for (const StencilRow::Entry& entry : row.entries()) {
    rows.indices.push_back(entry.index);
    rows.weights.push_back(entry.weight);
    if (derivatives == Derivatives::Yes) {
      rows.du_weights.push_back(entry.du);
      rows.dv_weights.push_back(entry.dv);
    }
  }
}

StencilRows<double> concatenate(std::vector<StencilRows<double>>&& pieces) {
  std::vector<std::size_t> first_row(pieces.size() + 1, 0), first_entry(pieces.size() + 1, 0);
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    first_row[p + 1] = first_row[p] + pieces[p].sizes.size();
    first_entry[p + 1] = first_entry[p] + pieces[p].indices.size();
  }
  const std::size_t entry_count = first_entry.back();
  if (entry_count >= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw Error(ErrorCode::OutOfMemory,
                "a stencil table of " + std::to_string(entry_count) +
                    " entries exceeds 2^31 - 1; split faces or vertices with thousands of edges");
  }
  if (pieces.size() == 1) return std::move(pieces.front());

  bool derivatives = false;
  for (const auto& piece : pieces) derivatives = derivatives || !piece.du_weights.empty();
  StencilRows<double> rows;
  rows.sizes.resize(first_row.back());
  rows.indices.resize(entry_count);
  rows.weights.resize(entry_count);
  rows.du_weights.resize(derivatives ? entry_count : 0);
  rows.dv_weights.resize(derivatives ? entry_count : 0);
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      StencilRows<double>& piece = pieces[p];
      const auto entry = static_cast<std::ptrdiff_t>(first_entry[p]);
      std::copy(piece.sizes.begin(), piece.sizes.end(),
                rows.sizes.begin() + static_cast<std::ptrdiff_t>(first_row[p]));
      std::copy(piece.indices.begin(), piece.indices.end(), rows.indices.begin() + entry);
      std::copy(piece.weights.begin(), piece.weights.end(), rows.weights.begin() + entry);
      if (derivatives) {
        std::copy(piece.du_weights.begin(), piece.du_weights.end(),
                  rows.du_weights.begin() + entry);
        std::copy(piece.dv_weights.begin(), piece.dv_weights.end(),
                  rows.dv_weights.begin() + entry);
      }
      piece = {};
    }
  });
  return rows;
}

}  // namespace planish
