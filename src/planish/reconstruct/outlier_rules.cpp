#include "planish/reconstruct/outlier_rules.h"

#include <array>
#include <string>

#include "planish/core/counted.h"
#include "planish/core/parallel.h"
#include "planish/reconstruct/clean.h"

namespace planish {
namespace {

// Of the mean distance to the nearest others: what a sheet's samples scatter by, and are off the
// fit to the others. Points all over a space scatter by 0.26 and more about fits to 24 (of 20,000).
constexpr double kMostScatter = 0.2, kMostOff = 0.3;
// What is farther off hides samples beside it, and goes first.
constexpr double kHidingOff = 0.5;
constexpr double kLeastSpread = 0.05;
constexpr std::size_t kNeighbours = 12, kSparseGrain = 256;
// So few are no part of a shape.
constexpr std::int64_t kFewestSamples = 2 * kFitNeighbours;

struct Verdict {
  bool hides = false, is_sample = false;
};

std::vector<Verdict> verdicts_on(std::span<const glm::dvec3> far) {
  const PointTree tree(far);
  std::vector<Verdict> verdicts(far.size());
  parallel_each(far.size(), kSparseGrain, [&](std::int32_t i) {
    std::array<Neighbour, kNeighbours + 1> nearest;
    const std::size_t found = tree.find_nearest(far[i], nearest);
    const double distance = mean_distance(std::span(nearest).subspan(1, found - 1), kNeighbours);
    const LocalFit fit = fit_at(i, far, tree);
    const bool judged = fit.others_deviation > 0;
    verdicts[i].hides = !judged || fit.distance > kHidingOff * distance;
    verdicts[i].is_sample = judged && fit.spread > kLeastSpread &&
                            fit.deviation < kMostScatter * distance &&
                            fit.distance < kMostOff * distance;
  });
  return verdicts;
}

std::vector<std::uint8_t> sparse_samples(std::span<const glm::dvec3> far) {
  std::vector<std::uint8_t> samples(far.size(), 0);
  if (std::ssize(far) < kFewestSamples) return samples;
  std::vector<std::size_t> open_to_view;
  std::vector<glm::dvec3> places;
  const std::vector<Verdict> first = verdicts_on(far);
  for (std::size_t i = 0; i < far.size(); ++i) {
    if (first[i].hides) continue;
    open_to_view.push_back(i);
    places.push_back(far[i]);
  }
  const std::vector<Verdict> second = verdicts_on(places);
  for (std::size_t i = 0; i < places.size(); ++i) samples[open_to_view[i]] = second[i].is_sample;
  if (std::ranges::count(samples, 1) < kFewestSamples) std::ranges::fill(samples, 0);
  return samples;
}

}  // namespace

void spare_sparse(std::vector<std::uint8_t>& is_far,
                  const std::function<glm::dvec3(std::size_t)>& place, const Callbacks& callbacks) {
  std::int64_t spared = std::ranges::count(is_far, 1);
  if (static_cast<double>(spared) > kMostOutliers * static_cast<double>(is_far.size())) {
    std::ranges::fill(is_far, 0);
  } else {
    std::vector<glm::dvec3> far;
    for (std::size_t i = 0; i < is_far.size(); ++i)
      if (is_far[i]) far.push_back(place(i));
    const std::vector<std::uint8_t> samples = sparse_samples(far);
    for (std::size_t i = 0, f = 0; i < is_far.size(); ++i)
      if (is_far[i]) is_far[i] = !samples[f++];
    spared = std::ranges::count(samples, 1);
  }
  if (spared > 0) warn_of_sparse(callbacks, "", spared);
}

void warn_of_sparse(const Callbacks& callbacks, std::string_view about, std::int64_t count) {
  callbacks.warn({.code = "uneven-density",
                  .message = std::string(about) + counted(count, "point") +
                             " lie far from their neighbours and are taken for a sparse part of "
                             "the shape; --outliers 12,2 removes them",
                  .count = count});
}

}  // namespace planish
