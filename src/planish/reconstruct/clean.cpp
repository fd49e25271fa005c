#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <iterator>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/reconstruct/point_tree.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/reconstruct/reconstruct_steps.h"
#include "planish/reconstruct/spatial_search.h"

namespace planish {
namespace {

// Points that a local surface is fitted to.
constexpr std::int32_t kFitNeighbours = 24;

// How a point lies in the quadratic height field, over the plane of their principal components,
// that fits its nearest points best, itself among them. Lengths are those of the points.
struct LocalFit {
  bool stable = false;
  glm::dvec3 normal{0.0};  // of the plane, unit, either way; 0 where there is no fit
  glm::dvec3 offset{0.0};  // from the point to the field, along its plane's normal
  double deviation = 0;    // standard deviation of the neighbours' heights about the field
  double spread = 0;       // second principal variance over the first: 0 for points of a line
  // From the field that the other neighbours alone give, and what that distance deviates by
  // where the point is one of them; 0, 0 where the field hangs on the point.
  double distance = 0, others_deviation = 0;
};

// To `count` points, kFitNeighbours at most.
LocalFit fit_at(std::int32_t index, std::span<const glm::dvec3> points, const PointTree& tree,
                std::int32_t count = kFitNeighbours);
LocalFit fit_at(std::int32_t index, const OrderedPoints& points, const OrderedTree& tree,
                std::int32_t count = kFitNeighbours);

// Based on: F. Cazals, M. Pouget, "Estimating Differential Quantities Using Polynomial Fitting of
// Osculating Jets", 2003: a truncated Taylor expansion of the height over the plane of the
// principal components, here of degree 2; and on R. D. Cook, "Detection of Influential Observation
// in Linear Regression", 1977: residuals without refitting, by leverages.

constexpr int kTerms = 6;  // 1, x, y, x^2, xy, y^2

// 1 - leverage below which a field passes through the point whatever the others do.
constexpr double kLeastRest = 1e-3;

using Terms = std::array<double, kTerms>;

Terms terms_at(double x, double y) { return {1, x, y, x * x, x * y, y * y}; }

// Cholesky's factor of a symmetric positive definite matrix in its lower half; false if it is
// singular to working precision.
bool factorise(std::array<Terms, kTerms>& matrix) {
  constexpr double kSmallestPivot = 1e-12;  // entries are of order 1 by scaling
  for (int i = 0; i < kTerms; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = matrix[i][j];
      for (int k = 0; k < j; ++k) sum -= matrix[i][k] * matrix[j][k];
      if (i == j) {
        if (!(sum > kSmallestPivot)) return false;
        matrix[i][i] = std::sqrt(sum);
      } else {
        matrix[i][j] = sum / matrix[j][j];
      }
    }
  }
  return true;
}

Terms solved(const std::array<Terms, kTerms>& factor, Terms right) {
  for (int i = 0; i < kTerms; ++i) {
    for (int k = 0; k < i; ++k) right[i] -= factor[i][k] * right[k];
    right[i] /= factor[i][i];
  }
  for (int i = kTerms - 1; i >= 0; --i) {
    for (int k = i + 1; k < kTerms; ++k) right[i] -= factor[k][i] * right[k];
    right[i] /= factor[i][i];
  }
  return right;
}

template <class Points>
LocalFit fit_at(const glm::dvec3& point, const Points& points,
                std::span<const Neighbour> neighbours) {
  const auto count = static_cast<double>(neighbours.size());
  const double radius = std::sqrt(neighbours.back().squared_distance);
  if (neighbours.size() <= kTerms || !(radius > 0)) return {};
  std::array<glm::dvec3, kFitNeighbours> offsets;  // from the point, in radii
  const auto nearby = std::span(offsets).first(neighbours.size());
  glm::dvec3 mean(0.0);
  for (std::size_t i = 0; i < nearby.size(); ++i)
    mean += nearby[i] = (points[neighbours[i].index] - point) / radius;
  mean /= count;
  glm::dmat3 covariance(0.0);
  for (const glm::dvec3& offset : nearby) {
    const glm::dvec3 d = offset - mean;
    covariance += glm::outerProduct(d, d);
  }
  const glm::dmat3 axes = eigenvectors(covariance);
  std::array<int, 3> order = {0, 1, 2};
  std::ranges::sort(order, {}, [&](int axis) { return std::pair(-covariance[axis][axis], axis); });
  const glm::dvec3 e1 = axes[order[0]], e2 = axes[order[1]], normal = axes[order[2]];

  std::array<Terms, kTerms> matrix{};
  Terms solution{};
  for (const glm::dvec3& d : nearby) {
    const Terms terms = terms_at(glm::dot(d, e1), glm::dot(d, e2));
    for (int i = 0; i < kTerms; ++i) {
      solution[i] += terms[i] * glm::dot(d, normal);
      for (int j = 0; j < kTerms; ++j) matrix[i][j] += terms[i] * terms[j];
    }
  }
  if (!factorise(matrix)) return {};
  solution = solved(matrix, solution);
  double squares = 0;
  for (const glm::dvec3& d : nearby) {
    const Terms terms = terms_at(glm::dot(d, e1), glm::dot(d, e2));
    double height = 0;
    for (int i = 0; i < kTerms; ++i) height += solution[i] * terms[i];
    squares += (height - glm::dot(d, normal)) * (height - glm::dot(d, normal));
  }
  // The point is the frame's origin, where only the constant term is left; so its leverage, the
  // share of its own height in its fitted one, is the first entry of the inverse.
  const double leverage = solved(matrix, {1})[0];
  const double rest = 1 - leverage;
  const double degrees = count - kTerms;
  LocalFit fit{.stable = std::abs(solution[0]) < 1,
               .normal = normal,
               .offset = radius * solution[0] * normal,
               .deviation = radius * std::sqrt(squares / degrees),
               .spread = covariance[order[1]][order[1]] / covariance[order[0]][order[0]]};
  if (rest > kLeastRest && degrees > 1) {
    const double without = std::max(squares - solution[0] * solution[0] / rest, 0.0);
    fit.distance = radius * std::abs(solution[0]) / rest;
    fit.others_deviation = radius * std::sqrt(without / ((degrees - 1) * rest));
  }
  return fit;
}

LocalFit fit_at(std::int32_t index, std::span<const glm::dvec3> points, const PointTree& tree,
                std::int32_t count) {
  std::array<Neighbour, kFitNeighbours> nearest;
  const auto wanted = std::span(nearest).first(static_cast<std::size_t>(count));
  const std::size_t found = tree.find_nearest(points[index], wanted);
  return fit_at(points[index], points, wanted.first(found));
}

LocalFit fit_at(std::int32_t index, const OrderedPoints& points, const OrderedTree& tree,
                std::int32_t count) {
  std::array<Neighbour, kFitNeighbours> nearest;
  const auto wanted = std::span(nearest).first(static_cast<std::size_t>(count));
  const glm::dvec3 point = points[index];
  const std::size_t found = tree.find_nearest(point, index, wanted);
  return fit_at(point, points, wanted.first(found));
}

// Of whose mean distance spacing is the median.
constexpr std::size_t kSpacingNeighbours = 6;
// How often removed points are followed by a look at those beside them: strays hide each other;
// those that another look would find are too few to matter.
constexpr int kOutlierLooks = 3;

// Whether a point strays from the surface around it: is no sample of it. Clouds with noise alone
// lose 1 in 10,000 points by the first limit; the second leaves alone what no surface would show.
bool is_stray(const LocalFit& fit, double spacing) {
  constexpr double kDeviations = 5, kSpacings = 0.2;
  return fit.distance > kDeviations * fit.others_deviation && fit.distance > kSpacings * spacing;
}
// The warning; `about` is a word before the count, or empty.
void warn_of_sparse(const Callbacks& callbacks, std::string_view about, std::int64_t count);

// Of the nearest `count` of a point's neighbours, nearest first, or of all where they are fewer.
double mean_distance(std::span<const Neighbour> others, std::size_t count) {
  const auto nearest = others.first(std::min(count, others.size()));
  double sum = 0;
  for (const Neighbour& other : nearest) sum += std::sqrt(other.squared_distance);
  return nearest.empty() ? 0 : sum / static_cast<double>(nearest.size());
}

// The upper one of an even number; 0 of none.
double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

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

// Takes the marks of points that are far from all others off those that are samples of a sparser
// part of the surface: off all where more than kMostOutliers are marked, else off those that lie
// on smooth sheets of their own, which outliers all over the space do not. `place` is asked for
// marked ones. Warns "uneven-density". Throws Error{Cancelled}.
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
    const auto by_distance = [](const Neighbour& n) {
      return std::pair(n.squared_distance, n.index);
    };
    std::ranges::partial_sort(
        nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(wanted),
        nearest.begin() + static_cast<std::ptrdiff_t>(count), {}, by_distance);
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
