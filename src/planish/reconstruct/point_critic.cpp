#include "planish/reconstruct/point_critic.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <iterator>
#include <numeric>
#include <string>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/reconstruct/outlier_rules.h"
#include "planish/reconstruct/smooth_points.h"

namespace planish {
namespace {

constexpr std::size_t kMostNeighbours = 100;  // of CleanOptions
constexpr std::size_t kSampledPoints = 20'000;
constexpr std::size_t kVerdictGrain = 256;

using Indices = std::vector<std::int32_t>;

// Takes the removed, ascending, out of ascending indices, and gives the others their new ones.
void renumber(Indices& indices, std::span<const std::int32_t> removed) {
  std::size_t kept = 0, before = 0;
  for (const std::int32_t index : indices) {
    while (before < removed.size() && removed[before] < index) ++before;
    if (before < removed.size() && removed[before] == index) continue;
    indices[kept++] = index - static_cast<std::int32_t>(before);
  }
  indices.resize(kept);
}

}  // namespace

PointCritic::PointCritic(OrderedPoints& points, const CleanOptions& options)
    : points_(points), options_(options), tree_(points) {
  const HostScope host(options.callbacks);
  if (points.size() > 0) measure_sample();
}

double PointCritic::noise() const { return measure_noise(points_, *tree_); }

std::vector<glm::dvec3> PointCritic::normals_at(std::span<const std::int32_t> asked) const {
  std::vector<glm::dvec3> normals(asked.size());
  parallel_each(asked.size(), kVerdictGrain,
                [&](std::size_t i) { normals[i] = fit_at(asked[i], points_, *tree_).normal; });
  return normals;
}

void PointCritic::measure_sample() {
  const auto neighbours = static_cast<std::size_t>(options_.neighbour_count);
  std::vector<double> wide, close;
  const auto measure = [&] {
    const std::size_t stride = (points_.size() + kSampledPoints - 1) / kSampledPoints;
    const std::size_t count = (points_.size() + stride - 1) / stride;
    wide.resize(count);
    close.resize(count);
    parallel_each(count, kVerdictGrain, [&](std::size_t s) {
      std::array<Neighbour, kMostNeighbours + 1> nearest;
      const std::size_t point = s * stride;
      const std::size_t found = tree_->find_nearest(
          points_[point], static_cast<std::int32_t>(point),
          std::span(nearest).first(std::max(neighbours, kSpacingNeighbours) + 1));
      // The first is the point itself: places are distinct.
      const auto others = std::span(nearest).subspan(1, found - 1);
      wide[s] = mean_distance(others, neighbours);
      close[s] = mean_distance(others, kSpacingNeighbours);
    });
  };
  measure();
  if (options_.outliers != OutlierRule::Off) {
    const double farthest = options_.factor * median_of(wide);
    const double share =
        static_cast<double>(std::ranges::count_if(wide, [&](double d) { return d > farthest; })) /
        static_cast<double>(wide.size());
    if (options_.outliers == OutlierRule::Auto && share > kMostOutliers) {
      warn_of_sparse(options_.callbacks, "about ",
                     static_cast<std::int64_t>(share * static_cast<double>(points_.size())));
    } else {
      remove_outliers(farthest);
      measure();
    }
  }
  spacing_ = median_of(std::move(close));
  if (options_.outliers != OutlierRule::Auto) return;
  std::vector<std::uint8_t> strays(wide.size());
  const std::size_t stride = (points_.size() + kSampledPoints - 1) / kSampledPoints;
  parallel_each(strays.size(), kVerdictGrain, [&](std::size_t s) {
    const auto point = static_cast<std::int32_t>(s * stride);
    strays[s] = is_stray(fit_at(point, points_, *tree_), spacing_);
  });
  judges_strays_ = static_cast<double>(std::ranges::count(strays, 1)) <=
                   kMostOutliers * static_cast<double>(strays.size());
}

// Points beside it along the curve bound what its nearest ones can give: most need no search.
bool PointCritic::is_outlier(std::int32_t point, double farthest) const {
  constexpr std::int32_t kAlongCurve = 16;
  const auto wanted = static_cast<std::size_t>(options_.neighbour_count);
  const glm::dvec3 place = points_[point];
  std::array<Neighbour, kMostNeighbours + 1> nearest;
  std::size_t count = 0;
  const std::int32_t end =
      std::min(point + kAlongCurve + 1, static_cast<std::int32_t>(points_.size()));
  for (std::int32_t i = std::max(point - kAlongCurve, 0); i < end; ++i) {
    const glm::dvec3 offset = points_[i] - place;
    if (i != point) nearest[count++] = {glm::dot(offset, offset), i};
  }
  if (count >= wanted) {
    std::ranges::nth_element(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(wanted),
                             nearest.begin() + static_cast<std::ptrdiff_t>(count), {},
                             &Neighbour::squared_distance);
    if (mean_distance(std::span(nearest).first(count), wanted) <= farthest) return false;
  }
  const std::size_t found = tree_->find_nearest(place, point, std::span(nearest).first(wanted + 1));
  return mean_distance(std::span(nearest).subspan(1, found - 1), wanted) > farthest;
}

void PointCritic::remove_outliers(double farthest) {
  std::vector<std::uint8_t> marks(points_.size());
  LoopProgress progress(options_.callbacks, "clean", 0.2, 1, std::ssize(marks));
  parallel_for(marks.size(), kVerdictGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      marks[i] = is_outlier(static_cast<std::int32_t>(i), farthest);
    progress.add(static_cast<std::int64_t>(end - begin));
  });
  if (options_.outliers == OutlierRule::Auto)
    spare_sparse(
        marks, [&](std::size_t i) { return points_[i]; }, options_.callbacks);
  outlier_count_ = std::ranges::count(marks, 1);
  if (outlier_count_ == 0) return;
  points_.drop(marks);
  tree_.emplace(points_);
}

// The points, ascending, beside which one was removed; `starts` are points not far from those.
Indices PointCritic::around(std::span<const glm::dvec3> places,
                            std::span<const std::int32_t> starts) const {
  Indices found;
  std::array<Neighbour, kFitNeighbours> nearest;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t count = tree_->find_nearest(places[i], starts[i], nearest);
    for (const Neighbour& neighbour : std::span(nearest).first(count))
      found.push_back(neighbour.index);
  }
  std::ranges::sort(found);
  found.erase(std::ranges::unique(found).begin(), found.end());
  return found;
}

void PointCritic::remove_strays(Indices& asked, Indices& followed) {
  if (!judges_strays_) return;
  Indices looked_at = asked;
  for (int look = 0; look < kOutlierLooks && !looked_at.empty(); ++look) {
    std::vector<std::uint8_t> strays(looked_at.size());
    parallel_each(looked_at.size(), kVerdictGrain, [&](std::size_t i) {
      strays[i] = is_stray(fit_at(looked_at[i], points_, *tree_), spacing_);
    });
    Indices removed, starts;
    std::vector<glm::dvec3> places;
    std::vector<std::uint8_t> marks(points_.size(), 0);
    for (std::size_t i = 0; i < looked_at.size(); ++i) {
      if (!strays[i]) continue;
      const std::int32_t point = looked_at[i];
      starts.push_back(std::max(point - static_cast<std::int32_t>(removed.size()) - 1, 0));
      removed.push_back(point);
      places.push_back(points_[point]);
      marks[point] = 1;
    }
    if (removed.empty()) break;
    stray_count_ += std::ssize(removed);
    points_.drop(marks);
    tree_.emplace(points_);
    renumber(asked, removed);
    renumber(followed, removed);
    if (points_.size() == 0) break;
    const Indices beside = around(places, starts);
    looked_at.clear();
    std::ranges::set_intersection(beside, asked, std::back_inserter(looked_at));
  }
}

void PointCritic::remove_all_strays() {
  Indices all(points_.size()), none;
  std::iota(all.begin(), all.end(), 0);
  remove_strays(all, none);
}

}  // namespace planish
