#include "planish/patches/patch_templates.h"

#include <algorithm>
#include <array>

#include "planish/core/parallel.h"
#include "planish/patches/patch_rings.h"

namespace planish {

namespace {

struct Place {
  std::int32_t a, b;
};

// The quarter that a sample lies in, and its place there seen from the quarter's own corner.
struct QuarterPlace {
  int quarter;
  Place place;
};

QuarterPlace in_quarter(Place sample, std::int32_t n) {
  const std::int32_t half = n / 2;
  const auto [a, b] = sample;
  if (b <= half) {
    if (a <= half) return {0, {a, b}};
    return {1, {b, n - a}};
  }
  if (a <= half) return {3, {n - b, a}};
  return {2, {n - a, n - b}};
}

// rows (count x inner) times matrix (inner x columns), added in the order of `inner`.
void multiply(const double* rows, std::size_t count, std::size_t inner, const double* matrix,
              std::size_t columns, double* result) {
  for (std::size_t r = 0; r < count; ++r, rows += inner, result += columns) {
    std::fill(result, result + columns, 0.0);
    for (std::size_t k = 0; k < inner; ++k) {
      const double weight = rows[k];
      if (weight == 0) continue;
      const double* row = matrix + k * columns;
      for (std::size_t j = 0; j < columns; ++j) result[j] += weight * row[j];
    }
  }
}

}  // namespace

const PatchTemplates::Grid& PatchTemplates::grid(const PatchClass& patch, int level) {
  const auto found = grids_.find({patch, level});
  if (found != grids_.end()) return *found->second;

  const PatchRings rings(patch);
  const auto columns = static_cast<std::size_t>(patch.column_count());
  auto result = std::make_unique<Grid>();
  if (level == 1) {
    for (const int corner : {0, 1, 3, 2}) {
      const PatchRowsOfWeights rows = rings.limit(corner);
      result->insert(result->end(), rows.begin(), rows.end());
    }
  } else {
    const std::int32_t n = PatchSamples(level).side();
    result->resize(static_cast<std::size_t>((n + 1) * (n + 1)) * 3 * columns);
    std::array<PatchRowsOfWeights, 4> points;
    std::array<const Grid*, 4> quarters;
    std::array<std::size_t, 4> inner;
    for (int q = 0; q < 4; ++q) {
      points[q] = rings.quarter_points(q, weights_);
      quarters[q] = &grid(rings.quarter_class(q), level - 1);
      inner[q] = static_cast<std::size_t>(rings.quarter_class(q).column_count());
    }
    parallel_for(static_cast<std::size_t>(n + 1), 4, [&](std::size_t begin, std::size_t end) {
      for (auto b = static_cast<std::int32_t>(begin); b < static_cast<std::int32_t>(end); ++b) {
        for (std::int32_t a = 0; a <= n; ++a) {
          const auto [q, place] = in_quarter({a, b}, n);
          const auto sample = static_cast<std::size_t>(place.b * (n / 2 + 1) + place.a);
          multiply(quarters[q]->data() + sample * 3 * inner[q], 3, inner[q], points[q].data(),
                   columns,
                   result->data() + static_cast<std::size_t>(b * (n + 1) + a) * 3 * columns);
        }
      }
    });
  }
  return *(grids_[{patch, level}] = std::move(result));
}

PatchTemplate PatchTemplates::make(const PatchClass& patch, int level) {
  const auto columns = static_cast<std::size_t>(patch.column_count());
  PatchTemplate result;
  result.column_count = patch.column_count() - 1;
  const auto add_sample = [&](const double* rows, std::size_t sample) {
    double* to = result.weights.data() + sample * 3 * (columns - 1);
    for (std::size_t row = 0; row < 3; ++row) {
      std::copy(rows + row * columns + 1, rows + (row + 1) * columns, to + row * (columns - 1));
    }
  };
  if (patch.is_limit_only()) {
    result.sample_count = 1;
    result.weights.resize(3 * (columns - 1));
    add_sample(PatchRings(patch).limit(0).data(), 0);
    return result;
  }
  const PatchSamples samples(level);
  const Grid& whole = grid(patch, level);
  const std::int32_t n = samples.side();
  result.sample_count = samples.count();
  result.weights.resize(static_cast<std::size_t>(samples.count()) * 3 * (columns - 1));
  for (std::int32_t b = 0; b <= n; ++b) {
    for (std::int32_t a = 0; a <= n; ++a) {
      add_sample(whole.data() + static_cast<std::size_t>(b * (n + 1) + a) * 3 * columns,
                 static_cast<std::size_t>(samples.index(a, b)));
    }
  }
  return result;
}

}  // namespace planish
