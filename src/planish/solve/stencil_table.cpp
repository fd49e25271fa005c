#include "planish/solve/stencil_table.h"

#include <glm/geometric.hpp>
#include <limits>
#include <string>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/solve/stencil_builder.h"

namespace planish {

std::vector<LevelCounts> split_counts(const LevelCounts& base, std::int64_t corner_count,
                                      int last) {
  std::vector<LevelCounts> counts{base};
  for (int l = 0; l < last; ++l) {
    const LevelCounts& c = counts.back();
    counts.push_back({c.vertices + c.edges + c.faces, 2 * c.edges + corner_count, corner_count});
    corner_count *= 4;
  }
  return counts;
}

namespace {

// Rows that a thread takes at least.
constexpr std::size_t kAppliedRows = 4096;

glm::vec3 unit_normal(const glm::dvec3& du, const glm::dvec3& dv) {
  const glm::dvec3 normal = glm::cross(du, dv);
  const double length = glm::length(normal);
  const bool degenerate =
      !(length >= kDegenerateNormal * glm::length(du) * glm::length(dv)) || length == 0;
  return degenerate ? glm::vec3(0.0f) : glm::vec3(normal / length);
}

}  // namespace

void apply(const StencilView<double>& table, std::span<const glm::dvec3> source,
           std::span<glm::dvec3> target) {
  PLANISH_ASSERT(table.source_count <= std::ssize(source) && target.size() == table.sizes.size());
  parallel_each(table.sizes.size(), kAppliedRows, [&](std::size_t i) {
    glm::dvec3 sum(0.0);
    const auto first = static_cast<std::size_t>(table.offsets[i]);
    for (std::size_t k = first; k < first + table.sizes[i]; ++k)
      sum += table.weights[k] * source[table.indices[k]];
    target[i] = sum;
  });
}

void apply_limit(const StencilView<double>& table, std::span<const glm::dvec3> source,
                 std::span<glm::dvec3> positions, std::span<glm::vec3> normals) {
  PLANISH_ASSERT(table.source_count <= std::ssize(source) &&
                 positions.size() == table.sizes.size() && normals.size() == positions.size());
  parallel_each(table.sizes.size(), kAppliedRows, [&](std::size_t i) {
    glm::dvec3 position(0.0), du(0.0), dv(0.0);
    const auto first = static_cast<std::size_t>(table.offsets[i]);
    for (std::size_t k = first; k < first + table.sizes[i]; ++k) {
      const glm::dvec3& point = source[table.indices[k]];
      position += table.weights[k] * point;
      du += table.du_weights[k] * point;
      dv += table.dv_weights[k] * point;
    }
    positions[i] = position;
    normals[i] = unit_normal(du, dv);
  });
}

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

void reserve(StencilTable& rows, std::size_t row_count, std::size_t entry_count,
             Derivatives derivatives) {
  rows.sizes.reserve(row_count);
  rows.indices.reserve(entry_count);
  rows.weights.reserve(entry_count);
  if (derivatives == Derivatives::No) return;
  rows.du_weights.reserve(entry_count);
  rows.dv_weights.reserve(entry_count);
}

void append(StencilTable& rows, const StencilRow& row, Derivatives derivatives) {
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

void require_entries_fit(std::int64_t entry_count) {
  if (entry_count <= std::numeric_limits<std::int32_t>::max()) return;
  throw Error(ErrorCode::OutOfMemory,
              formatted("a stencil table of up to {} entries exceeds 2^31 - 1; split faces or "
                        "vertices with thousands of edges",
                        entry_count));
}

StencilTable concatenate(std::int32_t source_count, std::vector<StencilTable>&& pieces) {
  std::vector<std::size_t> first_row(pieces.size() + 1, 0), first_entry(pieces.size() + 1, 0);
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    first_row[p + 1] = first_row[p] + pieces[p].sizes.size();
    first_entry[p + 1] = first_entry[p] + pieces[p].indices.size();
  }
  require_entries_fit(static_cast<std::int64_t>(first_entry.back()));
  StencilTable table;
  if (pieces.size() == 1) {
    table = std::move(pieces.front());
  } else {
    // `part` is a member of the table; pieces stand from `first` on.
    const auto join = [&](auto part, const std::vector<std::size_t>& first) {
      const bool has_part = std::ranges::any_of(
          pieces, [&](const StencilTable& piece) { return !(piece.*part).empty(); });
      if (!has_part) return;
      (table.*part).resize(first.back());
      parallel_each(pieces.size(), 1, [&](std::size_t p) {
        std::ranges::copy(pieces[p].*part,
                          (table.*part).begin() + static_cast<std::ptrdiff_t>(first[p]));
        pieces[p].*part = {};
      });
    };
    join(&StencilTable::sizes, first_row);
    join(&StencilTable::indices, first_entry);
    join(&StencilTable::weights, first_entry);
    join(&StencilTable::du_weights, first_entry);
    join(&StencilTable::dv_weights, first_entry);
  }
  table.close(source_count);
  return table;
}

StencilTable expanded(const SummedView& table) {
  const StencilView<double>&rows = table.rows, &sums = table.sums;
  const std::int32_t points = table.point_count();
  return build_rows(points, {0, rows.row_count()}, Derivatives::No, [&] {
    return [&](std::int32_t i, StencilRow& row) {
      for (std::int32_t k = rows.offsets[i]; k < rows.offsets[i] + rows.sizes[i]; ++k) {
        if (rows.indices[k] < points) {
          row.add(rows.indices[k], rows.weights[k]);
          continue;
        }
        const std::int32_t sum = rows.indices[k] - points;
        for (std::int32_t j = sums.offsets[sum]; j < sums.offsets[sum] + sums.sizes[sum]; ++j)
          row.add(sums.indices[j], rows.weights[k] * sums.weights[j]);
      }
    };
  });
}

double expansion(const SummedView& table) {
  const auto entries = static_cast<double>(table.rows.indices.size() + table.sums.indices.size());
  double expanded = 0;
  for (const std::int32_t source : table.rows.indices)
    expanded += source < table.point_count() ? 1 : table.sums.sizes[source - table.point_count()];
  return entries > 0 ? expanded / entries : 1;
}

}  // namespace planish
