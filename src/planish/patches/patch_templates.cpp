#include "planish/patches/patch_templates.h"

#include <algorithm>

#include "planish/core/parallel.h"
#include "planish/patches/patch_rings.h"
#include "planish/patches/quarter_turn.h"

namespace planish {

namespace {

// A quarter's sample and its place in the whole patch.
struct QuarterSample {
  std::size_t of_quarter, of_patch;
};

std::vector<QuarterSample> samples_of(int quarter, std::int32_t n) {
  std::vector<QuarterSample> samples;
  for (std::int32_t b = 0; b <= n; ++b) {
    for (std::int32_t a = 0; a <= n; ++a) {
      const int lies_in = 2 * b <= n ? (2 * a <= n ? 0 : 1) : (2 * a <= n ? 3 : 2);
      if (lies_in != quarter) continue;
      const auto [u, v] = seen_from(quarter, n, a, b);
      samples.push_back({static_cast<std::size_t>(v * (n / 2 + 1) + u),
                         static_cast<std::size_t>(b * (n + 1) + a)});
    }
  }
  return samples;
}

// result (columns) += weights times some rows, added in their order.
void add_rows(std::span<const double> weights, const double* rows, std::size_t columns,
              double* result) {
  for (const double weight : weights) {
    if (weight != 0) {
      for (std::size_t j = 0; j < columns; ++j) result[j] += weight * rows[j];
    }
    rows += columns;
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
    for (int q = 0; q < 4; ++q) add_quarter(rings, q, level, columns, *result);
  }
  return *(grids_[{patch, level}] = std::move(result));
}

// The quarter's template times its points, some of them at a time.
void PatchTemplates::add_quarter(const PatchRings& rings, int quarter, int level,
                                 std::size_t columns, Grid& result) {
  constexpr std::size_t kPointsAtOnce = 64;
  const Grid& weights = grid(rings.quarter_class(quarter), level - 1);
  const auto inner = static_cast<std::size_t>(rings.quarter_class(quarter).column_count());
  const std::vector<QuarterSample> samples = samples_of(quarter, PatchSamples(level).side());
  std::vector<double> points;
  std::size_t first = 0;
  const auto add_points = [&] {
    const std::size_t count = points.size() / columns;
    parallel_each(samples.size(), 16, [&](std::size_t s) {
      for (std::size_t r = 0; r < 3; ++r) {
        const std::size_t row = samples[s].of_quarter * 3 + r;
        add_rows({weights.data() + row * inner + first, count}, points.data(), columns,
                 result.data() + (samples[s].of_patch * 3 + r) * columns);
      }
    });
    first += count;
    points.clear();
  };
  rings.visit_quarter_points(quarter, weights_, [&](std::span<const double> row) {
    points.insert(points.end(), row.begin(), row.end());
    if (points.size() == kPointsAtOnce * columns) add_points();
  });
  add_points();
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
