#include "planish/reconstruct/clean.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/reconstruct/point_tree.h"

namespace planish {
namespace {

constexpr std::int32_t kMaxNeighbours = 100;
constexpr std::size_t kSpacingNeighbours = 6;
constexpr std::size_t kCleanGrain = 1024;

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

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// Mean distances of each point to its nearest ones.
struct Distances {
  std::vector<double> wide;   // to options.neighbour_count
  std::vector<double> close;  // to kSpacingNeighbours
};

double mean_distance(std::span<const Neighbour> others) {
  double sum = 0;
  for (const Neighbour& other : others) sum += std::sqrt(other.squared_distance);
  return others.empty() ? 0 : sum / static_cast<double>(others.size());
}

Distances measure(std::span<const glm::dvec3> points, const CleanOptions& options) {
  const PointTree tree(points);
  Distances distances{std::vector<double>(points.size()), std::vector<double>(points.size())};
  const std::size_t wide =
      options.outliers == OutlierRule::Off ? 0 : static_cast<std::size_t>(options.neighbour_count);
  LoopProgress progress(options.callbacks, "clean", 0.2, 1, std::ssize(points));
  parallel_for(points.size(), kCleanGrain, [&](std::size_t begin, std::size_t end) {
    std::array<Neighbour, kMaxNeighbours + 1> nearest;
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t wanted = std::max(wide, kSpacingNeighbours) + 1;
      const std::size_t found = tree.find_nearest(points[i], std::span(nearest).first(wanted));
      // The first is the point itself: places are distinct here.
      const auto others = std::span(nearest).subspan(1, found - 1);
      distances.wide[i] = mean_distance(others.first(std::min(wide, others.size())));
      distances.close[i] = mean_distance(others.first(std::min(kSpacingNeighbours, others.size())));
    }
    progress.add(static_cast<std::int64_t>(end - begin));
  });
  return distances;
}

void check_clean_options(const CleanOptions& options) {
  if (options.neighbour_count < 1 || options.neighbour_count > kMaxNeighbours)
    throw Error(ErrorCode::InvalidArgument, "outliers: " + std::to_string(options.neighbour_count) +
                                                " neighbours are asked for; 1 to " +
                                                std::to_string(kMaxNeighbours) + " work");
  if (!(options.factor > 0) || !std::isfinite(options.factor))
    throw Error(ErrorCode::InvalidArgument, "outliers: the factor must be a positive number");
}

}  // namespace

CleanPoints clean(std::span<const glm::dvec3> points, const CleanOptions& options) {
  check_clean_options(options);
  const HostScope host(options.callbacks);
  tell(options.callbacks, "clean", 0);
  CleanPoints result;
  result.kept = without_duplicates(points);
  result.duplicate_count = static_cast<std::int64_t>(points.size() - result.kept.size());

  std::vector<glm::dvec3> distinct;
  distinct.reserve(result.kept.size());
  for (const std::int32_t index : result.kept) distinct.push_back(points[index]);
  Distances distances = measure(distinct, options);
  if (options.outliers != OutlierRule::Off) {
    const double limit = options.factor * median_of(distances.wide);
    const auto far = std::ranges::count_if(distances.wide, [&](double d) { return d > limit; });
    const bool uneven = options.outliers == OutlierRule::Auto &&
                        static_cast<double>(far) > kMostOutliers * distinct.size();
    if (uneven) {
      options.callbacks.warn({.code = "uneven-density",
                              .message = counted(far, "point") +
                                         " lie far from their neighbours; so many are "
                                         "taken for a sparse part of the shape and kept; "
                                         "--outliers 12,2 removes them",
                              .count = far});
    } else {
      std::size_t kept = 0;
      for (std::size_t i = 0; i < distinct.size(); ++i) {
        if (distances.wide[i] > limit) continue;
        result.kept[kept] = result.kept[i];
        distances.close[kept++] = distances.close[i];
      }
      result.kept.resize(kept);
      distances.close.resize(kept);
      result.outlier_count = far;
    }
  }
  result.spacing = median_of(std::move(distances.close));
  tell(options.callbacks, "clean", 1.0);
  return result;
}

}  // namespace planish
