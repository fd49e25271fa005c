#include "planish/patches/patch_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "planish/core/assert.h"
#include "planish/patches/patch_rings.h"

namespace planish {
namespace {

// Rings of more points go by sums. Below, the products of whole rows take hardly longer, and are
// those that the rule is written in.
constexpr std::size_t kLargeRing = 32;
constexpr std::size_t kMostSums = 3;

void add_dense(std::span<const double> dense, PatchRows& rows) {
  for (std::size_t k = 0; k < dense.size(); ++k) {
    if (dense[k] != 0) rows.add(static_cast<std::int32_t>(k), dense[k]);
  }
  rows.end_row();
}

// X_i = P_i / 4 + sum_j (3 + 2 cos(2 pi (j - i) / n)) P_j / (4 n): with the cosine of the
// difference written out, the sums of P_j, cos_j P_j and sin_j P_j are all that is left of j.
void add_doo_sabin_ring(std::span<const std::int32_t> ring, std::int32_t first_sum,
                        PatchStep& step) {
  const auto n = static_cast<double>(ring.size());
  const auto angle = [n](std::size_t j) {
    return 2 * std::numbers::pi * static_cast<double>(j) / n;
  };
  for (const std::int32_t column : ring) step.sums.add(column, 1);
  step.sums.end_row();
  for (std::size_t j = 0; j < ring.size(); ++j) step.sums.add(ring[j], std::cos(angle(j)));
  step.sums.end_row();
  for (std::size_t j = 0; j < ring.size(); ++j) step.sums.add(ring[j], std::sin(angle(j)));
  step.sums.end_row();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    step.rows.add(ring[i], 0.25);
    step.rows.add(first_sum, 0.75 / n);
    step.rows.add(first_sum + 1, 0.5 / n * std::cos(angle(i)));
    step.rows.add(first_sum + 2, 0.5 / n * std::sin(angle(i)));
    step.rows.end_row();
  }
}

// X_i = P_i / 2 + (P_i-1 + P_i+1) / 8 + sum_j P_j / (4 n).
void add_averaged_ring(std::span<const std::int32_t> ring, std::int32_t first_sum,
                       PatchStep& step) {
  const std::size_t n = ring.size();
  for (const std::int32_t column : ring) step.sums.add(column, 1);
  step.sums.end_row();
  for (std::size_t i = 0; i < n; ++i) {
    step.rows.add(ring[i], 0.5);
    step.rows.add(ring[(i + n - 1) % n], 0.125);
    step.rows.add(ring[(i + 1) % n], 0.125);
    step.rows.add(first_sum, 0.25 / static_cast<double>(n));
    step.rows.end_row();
  }
}

}  // namespace

void PatchRows::add(std::int32_t column, double weight) {
  columns.push_back(column);
  weights.push_back(weight);
}

void PatchStep::apply(std::span<const glm::dvec3> points, std::vector<glm::dvec3>& result) const {
  result.resize(rows.row_count());
  if (sums.empty()) {
    for (std::size_t k = 0; k < result.size(); ++k)
      result[k] = rows.combine(k, points.data()).value();
    return;
  }
  std::array<glm::dvec3, kMostSums> summed{};
  for (std::size_t s = 0; s < sums.row_count(); ++s)
    summed[s] = sums.combine(s, points.data()).value();
  for (std::size_t k = 0; k < result.size(); ++k) {
    VectorSum sum;
    for (auto i = rows.offsets[k]; i < rows.offsets[k + 1]; ++i) {
      const auto column = static_cast<std::size_t>(rows.columns[i]);
      sum.add(rows.weights[i],
              column < points.size() ? points[column] : summed[column - points.size()]);
    }
    result[k] = sum.value();
  }
}

PatchStep make_step(const PatchRings& rings, int quarter, const FaceWeights& weights,
                    std::int32_t column_count) {
  PatchStep step;
  const auto add_row = [&](std::span<const double> row) { add_dense(row, step.rows); };
  const std::span<const std::int32_t> ring = rings.ring_columns(quarter);
  if (ring.size() <= kLargeRing) {
    rings.visit_ring_points(quarter, weights, add_row);
  } else if (weights.weights() == Weights::DooSabin) {
    add_doo_sabin_ring(ring, column_count, step);
  } else {
    add_averaged_ring(ring, column_count, step);
  }
  PLANISH_ASSERT(step.sums.row_count() <= kMostSums);
  rings.visit_further_points(quarter, weights, add_row);
  return step;
}

std::vector<double> pulled_back(std::span<const double> rows, const PatchRows& map,
                                std::size_t columns) {
  const std::size_t inner = map.row_count(), row_count = rows.size() / inner;
  std::vector<double> result(row_count * columns, 0.0);
  for (std::size_t r = 0; r < row_count; ++r) {
    for (std::size_t k = 0; k < inner; ++k) {
      const double weight = rows[r * inner + k];
      if (weight == 0) continue;
      for (auto i = map.offsets[k]; i < map.offsets[k + 1]; ++i)
        result[r * columns + static_cast<std::size_t>(map.columns[i])] += weight * map.weights[i];
    }
  }
  return result;
}

std::vector<double> pulled_back(std::span<const double> rows, const PatchStep& step,
                                std::size_t columns) {
  if (step.sums.empty()) return pulled_back(rows, step.rows, columns);
  const std::size_t sum_count = step.sums.row_count(), wide = columns + sum_count;
  const std::vector<double> with_sums = pulled_back(rows, step.rows, wide);
  const std::size_t row_count = with_sums.size() / wide;
  std::vector<double> result;
  for (std::size_t r = 0; r < row_count; ++r) {
    const std::span row = std::span(with_sums).subspan(r * wide, wide);
    std::vector<double> whole = pulled_back(row.subspan(columns), step.sums, columns);
    std::transform(whole.begin(), whole.end(), row.begin(), whole.begin(), std::plus());
    result.insert(result.end(), whole.begin(), whole.end());
  }
  return result;
}

}  // namespace planish
