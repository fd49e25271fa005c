#include "planish/reconstruct/smooth_points.h"

#include <algorithm>
#include <cmath>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/reconstruct/local_fit.h"

namespace planish {
namespace {

constexpr std::size_t kSmoothGrain = 256;

// Of the noise, from which on neighbours lie on both sides of an edge: 1.5 leaves noise beside
// edges, 4 begins to round them.
constexpr double kEdgeDeviations = 2.5;

// Medians of chi-square distributions over their means, for 12 and 24 points less 6 terms.
constexpr double kMedianOfFew = 0.8914, kMedianOfMany = 0.9632;

// Of heights about the fits to `count` points around every `stride`-th.
double median_variance(std::span<const glm::dvec3> points, const PointTree& tree,
                       std::size_t stride, std::int32_t count) {
  std::vector<double> variances;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const LocalFit fit = fit_at(static_cast<std::int32_t>(i), points, tree, count);
    if (fit.stable) variances.push_back(fit.deviation * fit.deviation);
  }
  if (variances.empty()) return 0;
  const auto middle = variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 2);
  std::ranges::nth_element(variances, middle);
  return *middle;
}

// Whether there is a surface to move a point onto: what deviates by more than noise is an edge.
bool follows(const LocalFit& fit, double noise) {
  return fit.stable && (noise <= 0 || fit.deviation <= kEdgeDeviations * noise);
}

}  // namespace

std::vector<glm::dvec3> smooth_points(std::span<const glm::dvec3> points, std::int32_t rounds,
                                      double noise, const Callbacks& callbacks) {
  const HostScope host(callbacks);
  std::vector<glm::dvec3> current(points.begin(), points.end());
  std::vector<glm::dvec3> next(current);
  for (std::int32_t round = 0; round < rounds && !points.empty(); ++round) {
    const PointTree tree(current);
    LoopProgress progress(callbacks, "smooth", (round + 0.1) / rounds, (round + 1.0) / rounds,
                          std::ssize(current));
    parallel_for(current.size(), kSmoothGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const LocalFit fit = fit_at(static_cast<std::int32_t>(i), current, tree);
        next[i] = follows(fit, noise) ? current[i] + fit.offset : current[i];
      }
      progress.add(static_cast<std::int64_t>(end - begin));
    });
    std::swap(current, next);
  }
  if (rounds > 0) callbacks.report("smooth", 1.0);
  return current;
}

double measure_noise(std::span<const glm::dvec3> points, std::int32_t sample_count) {
  if (points.empty() || sample_count < 1) return 0;
  const PointTree tree(points);
  const std::size_t stride = (points.size() - 1) / static_cast<std::size_t>(sample_count) + 1;
  const double few = median_variance(points, tree, stride, kFitNeighbours / 2) / kMedianOfFew;
  const double many = median_variance(points, tree, stride, kFitNeighbours) / kMedianOfMany;
  return std::sqrt(std::max(2 * few - many, 0.0));
}

}  // namespace planish
