#include "planish/reconstruct/smooth_points.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/reconstruct/local_fit.h"
#include "planish/reconstruct/outlier_rules.h"

namespace planish {
namespace {

constexpr std::size_t kSmoothGrain = 256;

// Of the noise, from which on neighbours lie on both sides of an edge: 1.5 leaves noise beside
// edges, 4 begins to round them.
constexpr double kEdgeDeviations = 2.5;

// Medians of chi-square distributions over their means, for 12 and 24 points less 6 terms.
constexpr double kMedianOfFew = 0.8914, kMedianOfMany = 0.9632;

// Whether there is a surface to move a point onto: what deviates by more than noise is an edge.
bool follows(const LocalFit& fit, double noise) {
  return fit.stable && (noise <= 0 || fit.deviation <= kEdgeDeviations * noise);
}

// Fills `next` with the points on their local fits.
template <class Points, class Tree>
void move_onto_fits(const Points& points, const Tree& tree, double noise, LoopProgress& progress,
                    std::vector<glm::dvec3>& next) {
  next.resize(points.size());
  parallel_for(points.size(), kSmoothGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const LocalFit fit = fit_at(static_cast<std::int32_t>(i), points, tree);
      next[i] = follows(fit, noise) ? points[i] + fit.offset : points[i];
    }
    progress.add(static_cast<std::int64_t>(end - begin));
  });
}

// Calls round(progress) for each.
template <class Round>
void in_rounds(std::int32_t rounds, std::size_t count, const Callbacks& callbacks,
               const Round& round) {
  const HostScope host(callbacks);
  for (std::int32_t r = 0; r < rounds && count > 0; ++r) {
    LoopProgress progress(callbacks, "smooth", (r + 0.1) / rounds, (r + 1.0) / rounds,
                          static_cast<std::int64_t>(count));
    round(progress);
  }
  if (rounds > 0) callbacks.report("smooth", 1.0);
}

// Of heights about the fits to `count` points around every `stride`-th.
template <class Points, class Tree>
double median_variance(const Points& points, const Tree& tree, std::size_t stride,
                       std::int32_t count) {
  std::vector<double> variances;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const LocalFit fit = fit_at(static_cast<std::int32_t>(i), points, tree, count);
    if (fit.stable) variances.push_back(fit.deviation * fit.deviation);
  }
  return median_of(std::move(variances));
}

template <class Points, class Tree>
double noise_of(const Points& points, const Tree& tree, std::int32_t sample_count) {
  if (points.size() == 0 || sample_count < 1) return 0;
  const std::size_t stride = (points.size() - 1) / static_cast<std::size_t>(sample_count) + 1;
  const double few = median_variance(points, tree, stride, kFitNeighbours / 2) / kMedianOfFew;
  const double many = median_variance(points, tree, stride, kFitNeighbours) / kMedianOfMany;
  return std::sqrt(std::max(2 * few - many, 0.0));
}

}  // namespace

std::vector<glm::dvec3> smooth_points(std::span<const glm::dvec3> points, std::int32_t rounds,
                                      double noise, const Callbacks& callbacks) {
  std::vector<glm::dvec3> current(points.begin(), points.end()), next;
  in_rounds(rounds, points.size(), callbacks, [&](LoopProgress& progress) {
    move_onto_fits(current, PointTree(current), noise, progress, next);
    std::swap(current, next);
  });
  return current;
}

void smooth_points(OrderedPoints& points, std::int32_t rounds, double noise,
                   const Callbacks& callbacks) {
  std::vector<glm::dvec3> next;
  in_rounds(rounds, points.size(), callbacks, [&](LoopProgress& progress) {
    move_onto_fits(points, OrderedTree(points), noise, progress, next);
    points.move_to(std::exchange(next, {}));
  });
}

double measure_noise(std::span<const glm::dvec3> points, std::int32_t sample_count) {
  return noise_of(points, PointTree(points), sample_count);
}

double measure_noise(const OrderedPoints& points, const OrderedTree& tree,
                     std::int32_t sample_count) {
  return noise_of(points, tree, sample_count);
}

}  // namespace planish
