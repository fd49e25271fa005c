#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <numeric>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"

namespace planish {

/// Element counts of one level of refinement.
struct LevelCounts {
  std::int64_t vertices, edges, faces;
};

/// Those of the levels 0 to `last` of a mesh with so many elements and corners, every face of which
/// is cut into quads at each step: a quad a corner.
[[nodiscard]] std::vector<LevelCounts> split_counts(const LevelCounts& base,
                                                    std::int64_t corner_count, int last);

/// Read-only view of sparse rows: row i is the sum over k in [offsets[i], offsets[i] + sizes[i]) of
/// weights[k] * source[indices[k]].
template <class Real>
struct StencilView {
  std::int32_t source_count = 0;
  std::span<const std::int32_t> sizes, offsets, indices;
  std::span<const Real> weights;
  /// Derivative weights on the same indices, as many as weights; empty where the rows have none.
  std::span<const Real> du_weights, dv_weights;

  [[nodiscard]] std::int32_t row_count() const { return static_cast<std::int32_t>(sizes.size()); }
};

/// Rows in arrays that threads fill; to_far() makes OpenSubdiv's tables of them.
struct StencilTable {
  std::int32_t source_count = 0;
  RawVector<std::int32_t> sizes, offsets, indices;
  RawVector<double> weights;
  RawVector<double> du_weights, dv_weights;  ///< empty, or as long as weights

  /// Completes rows without gaps of which sizes, indices and weights are there.
  void close(std::int32_t sources) {
    source_count = sources;
    offsets.resize(sizes.size());
    std::exclusive_scan(sizes.begin(), sizes.end(), offsets.begin(), 0);
  }

  [[nodiscard]] StencilView<double> view() const {
    return {source_count, sizes, offsets, indices, weights, du_weights, dv_weights};
  }
};

/// target[i] = row i of `table` applied to `source`, on the caller's threads.
void apply(const StencilView<double>& table, std::span<const glm::dvec3> source,
           std::span<glm::dvec3> target);

/// du x dv shorter than this times |du||dv| is no normal: the tangents are parallel up to rounding.
inline constexpr double kDegenerateNormal = 1e-6;

/// Limit points and unit normals du x dv / |du x dv|, one per row. A normal whose |du x dv| <
/// kDegenerateNormal |du||dv| is zero: the caller replaces it.
void apply_limit(const StencilView<double>& table, std::span<const glm::dvec3> source,
                 std::span<glm::dvec3> positions, std::span<glm::vec3> normals);

/// Rows over points and, behind them, over sums of these: source i of `rows` is point i, or the sum
/// i - point_count(). What each corner of a large face takes of all the others stands there once.
struct SummedView {
  StencilView<double> rows, sums;

  SummedView(const StencilView<double>& all_rows, const StencilView<double>& all_sums = {})
      : rows(all_rows), sums(all_sums) {}
  [[nodiscard]] std::int32_t sum_count() const { return sums.row_count(); }
  [[nodiscard]] std::int32_t point_count() const { return rows.source_count - sum_count(); }
};

struct SummedTable {
  StencilTable rows, sums;

  [[nodiscard]] SummedView view() const { return {rows.view(), sums.view()}; }
  [[nodiscard]] std::int64_t entry_count() const {
    return static_cast<std::int64_t>(rows.weights.size() + sums.weights.size());
  }
};

}  // namespace planish
