#include "planish/reconstruct/clean.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <string>

#include "planish/core/drop_marked.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/reconstruct/chosen.h"
#include "planish/reconstruct/local_fit.h"
#include "planish/reconstruct/outlier_rules.h"
#include "planish/reconstruct/point_tree.h"

namespace planish {
namespace {

constexpr std::int32_t kMaxNeighbours = 100;
constexpr std::size_t kCleanGrain = 1024, kStrayGrain = 256;
// Share of the time when densities are known.
constexpr double kDensityDone = 0.4;

std::uint64_t hash_of(const glm::dvec3& point) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    hash ^= std::bit_cast<std::uint64_t>(point[axis] + 0.0);  // -0 and 0 are one place
    hash *= 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  return hash;
}

std::vector<std::int32_t> without_duplicates(std::span<const glm::dvec3> points) {
  struct Entry {
    std::uint64_t hash;
    std::int32_t index;
  };
  std::vector<Entry> entries(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    entries[i] = {hash_of(points[i]), static_cast<std::int32_t>(i)};
  std::ranges::sort(entries, [](const Entry& a, const Entry& b) {
    return a.hash < b.hash || (a.hash == b.hash && a.index < b.index);
  });
  std::vector<std::uint8_t> repeated(points.size(), 0);
  for (std::size_t begin = 0, end; begin < entries.size(); begin = end) {
    for (end = begin + 1; end < entries.size() && entries[end].hash == entries[begin].hash; ++end) {
      // Different places with one hash are as good as impossible, but must not merge.
      for (std::size_t i = begin; i < end && !repeated[entries[end].index]; ++i)
        repeated[entries[end].index] = points[entries[i].index] == points[entries[end].index];
    }
  }
  std::vector<std::int32_t> kept;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!repeated[i]) kept.push_back(static_cast<std::int32_t>(i));
  return kept;
}

// Mean distances of each point to its nearest ones.
struct Distances {
  std::vector<double> wide;   // to options.neighbour_count
  std::vector<double> close;  // to kSpacingNeighbours
};

Distances measure(std::span<const glm::dvec3> points, const CleanOptions& options) {
  const PointTree tree(points);
  Distances distances{std::vector<double>(points.size()), std::vector<double>(points.size())};
  const std::size_t wide =
      options.outliers == OutlierRule::Off ? 0 : static_cast<std::size_t>(options.neighbour_count);
  LoopProgress progress(options.callbacks, "clean", 0.1, kDensityDone, std::ssize(points));
  parallel_for(points.size(), kCleanGrain, [&](std::size_t begin, std::size_t end) {
    std::array<Neighbour, kMaxNeighbours + 1> nearest;
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t wanted = std::max(wide, kSpacingNeighbours) + 1;
      const std::size_t found = tree.find_nearest(points[i], std::span(nearest).first(wanted));
      // The first is the point itself: places are distinct here.
      const auto others = std::span(nearest).subspan(1, found - 1);
      distances.wide[i] = mean_distance(others, wide);
      distances.close[i] = mean_distance(others, kSpacingNeighbours);
    }
    progress.add(static_cast<std::int64_t>(end - begin));
  });
  return distances;
}

// Which of the points named by `looked_at` are off the surface around them.
std::vector<std::int32_t> strays_among(std::span<const std::int32_t> looked_at,
                                       std::span<const glm::dvec3> points, const PointTree& tree,
                                       double spacing, LoopProgress& progress) {
  std::vector<std::uint8_t> strayed(looked_at.size(), 0);
  parallel_for(looked_at.size(), kStrayGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      strayed[i] = is_stray(fit_at(looked_at[i], points, tree), spacing);
    }
    progress.add(static_cast<std::int64_t>(end - begin));
  });
  std::vector<std::int32_t> strays;
  for (std::size_t i = 0; i < looked_at.size(); ++i)
    if (strayed[i]) strays.push_back(looked_at[i]);
  return strays;
}

// The points beside which one was removed, ascending.
std::vector<std::int32_t> points_around(std::span<const glm::dvec3> removed,
                                        const PointTree& tree) {
  std::vector<std::int32_t> around;
  std::array<Neighbour, kFitNeighbours> nearest;
  for (const glm::dvec3& place : removed) {
    const std::size_t found = tree.find_nearest(place, nearest);
    for (const Neighbour& neighbour : std::span(nearest).first(found))
      around.push_back(neighbour.index);
  }
  std::ranges::sort(around);
  around.erase(std::ranges::unique(around).begin(), around.end());
  return around;
}

// Removes points that stick out of the surface around them, unless these are so many that they
// are a part of the shape.
void drop_strays(std::vector<glm::dvec3> points, const Callbacks& callbacks, CleanPoints& result) {
  const auto most = static_cast<std::int64_t>(kMostOutliers * static_cast<double>(points.size()));
  std::vector<std::int32_t> kept = result.kept, looked_at(points.size());
  std::iota(looked_at.begin(), looked_at.end(), 0);
  LoopProgress progress(callbacks, "clean", kDensityDone, 1, std::ssize(points));
  std::int64_t count = 0;
  PointTree tree(points);
  for (int look = 0; look < kOutlierLooks; ++look) {
    const std::vector<std::int32_t> strays =
        strays_among(looked_at, points, tree, result.spacing, progress);
    if (strays.empty()) break;
    count += std::ssize(strays);
    if (count > most) return;
    const std::vector<glm::dvec3> removed = chosen(points, strays);
    std::vector<std::uint8_t> strayed(points.size(), 0);
    for (const std::int32_t stray : strays) strayed[stray] = 1;
    drop_marked(kept, strayed);
    drop_marked(points, strayed);
    tree = PointTree(points);
    looked_at = points_around(removed, tree);
  }
  result.kept = std::move(kept);
  result.stray_count = count;
}

void check_clean_options(const CleanOptions& options) {
  if (options.neighbour_count < 1 || options.neighbour_count > kMaxNeighbours)
    throw Error(ErrorCode::InvalidArgument,
                formatted("outliers: {} neighbours are asked for; 1 to {} work",
                          options.neighbour_count, kMaxNeighbours));
  if (!(options.factor > 0) || !std::isfinite(options.factor))
    throw Error(ErrorCode::InvalidArgument, "outliers: the factor must be a positive number");
}

}  // namespace

CleanPoints clean(std::span<const glm::dvec3> points, const CleanOptions& options) {
  check_clean_options(options);
  const HostScope host(options.callbacks);
  options.callbacks.report("clean", 0);
  CleanPoints result;
  result.kept = without_duplicates(points);
  result.duplicate_count = static_cast<std::int64_t>(points.size() - result.kept.size());

  std::vector<glm::dvec3> distinct = chosen(points, result.kept);
  Distances distances = measure(distinct, options);
  if (options.outliers != OutlierRule::Off) {
    const double limit = options.factor * median_of(distances.wide);
    std::vector<std::uint8_t> is_far(distinct.size());
    for (std::size_t i = 0; i < is_far.size(); ++i) is_far[i] = distances.wide[i] > limit;
    if (options.outliers == OutlierRule::Auto)
      spare_sparse(
          is_far, [&](std::size_t i) { return distinct[i]; }, options.callbacks);
    drop_marked(result.kept, is_far);
    drop_marked(distinct, is_far);
    drop_marked(distances.close, is_far);
    result.outlier_count = std::ranges::count(is_far, 1);
  }
  result.spacing = median_of(std::move(distances.close));
  if (options.outliers == OutlierRule::Auto)
    drop_strays(std::move(distinct), options.callbacks, result);
  options.callbacks.report("clean", 1.0);
  return result;
}

}  // namespace planish
