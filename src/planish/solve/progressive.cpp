#include "planish/solve/progressive.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "planish/core/callbacks.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/raw_vector.h"
#include "planish/solve/iteration.h"

namespace planish {
namespace {

// A sum of points about its first one, and the sum of its weights.
struct SumAbout {
  glm::dvec3 origin{0.0}, sum{0.0};
  double weight = 0;

  // Of (from - point) over its points.
  [[nodiscard]] glm::dvec3 way_from(const glm::dvec3& from) const {
    return weight * (from - origin) - sum;
  }
};

SumAbout sum_about(const StencilView<double>& sums, std::size_t row,
                   std::span<const glm::dvec3> points) {
  const auto first = static_cast<std::size_t>(sums.offsets[row]);
  SumAbout result{points[sums.indices[first]]};
  for (std::size_t k = first; k < first + static_cast<std::size_t>(sums.sizes[row]); ++k) {
    result.sum += sums.weights[k] * (points[sums.indices[k]] - result.origin);
    result.weight += sums.weights[k];
  }
  return result;
}

}  // namespace

RawVector<glm::dvec3> initial_residual(const SummedView& masks, std::span<const glm::dvec3> given) {
  const StencilView<double>& rows = masks.rows;
  RawVector<SumAbout> sums(static_cast<std::size_t>(masks.sum_count()));
  parallel_each(sums.size(), 1, [&](std::size_t s) { sums[s] = sum_about(masks.sums, s, given); });
  RawVector<glm::dvec3> residual(given.size());
  parallel_each(given.size(), [&](std::size_t i) {
    glm::dvec3 sum(0.0);
    for (std::int32_t k = rows.offsets[i]; k < rows.offsets[i] + rows.sizes[i]; ++k) {
      const auto source = static_cast<std::size_t>(rows.indices[k]);
      sum += rows.weights[k] * (source < given.size()
                                    ? given[i] - given[source]
                                    : sums[source - given.size()].way_from(given[i]));
    }
    residual[i] = sum;
  });
  return residual;
}

RawVector<glm::dvec3> sums_of(const SummedView& table, std::span<const glm::dvec3> points) {
  const StencilView<double>& sums = table.sums;
  RawVector<glm::dvec3> result(static_cast<std::size_t>(table.sum_count()));
  parallel_each(result.size(), 1, [&](std::size_t row) {
    glm::dvec3 sum(0.0);
    for (std::int32_t k = sums.offsets[row]; k < sums.offsets[row] + sums.sizes[row]; ++k)
      sum += sums.weights[k] * points[sums.indices[k]];
    result[row] = sum;
  });
  return result;
}

// Based on: Golub & Varga, "Chebyshev semi-iterative methods", 1961.

StepCoefficients ChebyshevSequence::next() {
  if (first_) {
    first_ = false;
    return {0.0, 1.0 / theta_};
  }
  const double next_rho = 1.0 / (2.0 * theta_ / delta_ - rho_);
  const StepCoefficients step{next_rho * rho_, 2.0 * next_rho / delta_};
  rho_ = next_rho;
  return step;
}

std::vector<StepCoefficients> chebyshev_steps(double bound, std::int32_t count) {
  ChebyshevSequence sequence(bound);
  std::vector<StepCoefficients> steps(static_cast<std::size_t>(count));
  for (StepCoefficients& step : steps) step = sequence.next();
  return steps;
}

double chebyshev_step_count(double bound, double factor) {
  const double root = std::sqrt(1.0 / bound);
  const double sigma = (root - 1) / (root + 1);
  return std::max(std::ceil(portable::log(2 / factor) / -portable::log(sigma)), 0.0);
}

namespace {

// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3.2, and
// Golub & Varga, "Chebyshev semi-iterative methods", 1961.
// The paper's symbols: V0 `given`, V = V0 + d with d the `displacement`, B `limit_masks`,
// D^k = V0 - B V^k the residual. Solving for d instead of V keeps single precision's rounding
// relative to d: r_0 = sum_j b_ij (V0_i - V0_j) is taken in double, then B d = r_0.

// Steps between two looks of the host: enough to hide the round trip, few enough to cancel soon.
constexpr std::int32_t kBatchSteps = 32;

// A batch that does not lower the error by this factor makes no progress: the slowest of our
// spectra gains a factor 0.75 a step.
constexpr double kStagnationFactor = 0.9;

// The spectrum lies in (0, 1], where no step can enlarge the error much; beyond this it diverges.
constexpr double kDivergenceFactor = 1e3;

// Shares of the time that go before and after the steps.
constexpr double kSolveBegins = 0.35, kSolveEnds = 0.9;

// Rows that a thread takes at least.
constexpr std::size_t kSummedRows = 4096;

// The true residual in double, whatever the device computed in.
RawVector<glm::dvec3> residual_of(const SummedView& table, std::span<const glm::dvec3> initial,
                                  std::span<const glm::dvec3> displacement) {
  const StencilView<double>& masks = table.rows;
  const RawVector<glm::dvec3> sums = sums_of(table, displacement);
  RawVector<glm::dvec3> result(initial.size());
  parallel_each(initial.size(), kSummedRows, [&](std::size_t i) {
    glm::dvec3 residual = initial[i];
    for (std::int32_t k = masks.offsets[i]; k < masks.offsets[i] + masks.sizes[i]; ++k) {
      const auto source = static_cast<std::size_t>(masks.indices[k]);
      residual -=
          masks.weights[k] * (source < displacement.size() ? displacement[source]
                                                           : sums[source - displacement.size()]);
    }
    result[i] = residual;
  });
  return result;
}

void note_error(std::span<const glm::dvec3> residual, Interpolation& result) {
  struct Piece {
    double sum = 0, largest = -1;
    std::size_t worst = 0;
  };
  const auto piece_of = [&](std::size_t begin, std::size_t end) {
    Piece piece;
    for (std::size_t i = begin; i < end; ++i) {
      double square = glm::dot(residual[i], residual[i]);
      if (!std::isfinite(square)) square = std::numeric_limits<double>::infinity();
      piece.sum += square;
      if (square > piece.largest) {
        piece.largest = square;
        piece.worst = i;
      }
    }
    return piece;
  };
  const auto join = [](Piece& total, const Piece& piece) {
    total.sum += piece.sum;
    if (piece.largest > total.largest) {
      total.largest = piece.largest;
      total.worst = piece.worst;
    }
  };
  const Piece total = ordered_reduce(residual.size(), kSummedRows, Piece{}, piece_of, join);
  if (!residual.empty()) result.worst_vertex = static_cast<std::int64_t>(total.worst);
  result.error = {
      std::sqrt(std::max(total.largest, 0.0)),
      residual.empty() ? 0.0 : std::sqrt(total.sum / static_cast<double>(residual.size()))};
}

std::int32_t first_batch_size(double initial_error, const InterpolationOptions& options) {
  const double count =
      chebyshev_step_count(options.spectral_bound, options.tolerance / initial_error);
  return static_cast<std::int32_t>(std::max(1.0, std::min<double>(count, options.max_iterations)));
}

// Follows the errors from batch to batch.
class ProgressWatch {
 public:
  explicit ProgressWatch(double initial_error) : initial_(initial_error), best_(initial_error) {}

  [[nodiscard]] bool diverged(double error) const {
    return !(error <= kDivergenceFactor * initial_);
  }
  // Only full batches count: the last steps of a count fixed in advance prove nothing.
  [[nodiscard]] bool stagnates(std::span<const ErrorNorms> batch) {
    double best = best_;
    for (const ErrorNorms& error : batch) best = std::min(best, error.max);
    const bool stuck =
        static_cast<std::int32_t>(batch.size()) >= kBatchSteps && best > kStagnationFactor * best_;
    best_ = best;
    return stuck;
  }
  // The error falls by a like factor a step, so that its logarithm says how far the way is; or the
  // steps that are allowed do.
  void tell(const Interpolation& result, const InterpolationOptions& options) {
    const double steps = static_cast<double>(result.iterations) / options.max_iterations;
    const double decades = portable::log(initial_ / result.history.back().max) /
                           portable::log(initial_ / (kStopMargin * options.tolerance));
    if (decades > done_) done_ = std::min(decades, 1.0);
    done_ = std::max(done_, steps);
    options.callbacks.report("solve", std::lerp(kSolveBegins, kSolveEnds, done_));
  }

 private:
  double initial_, best_, done_ = 0;
};

}  // namespace

// Batches of steps until the error is low enough.
void take_steps(StepSolve& solve, double initial_error, const InterpolationOptions& options,
                Interpolation& result) {
  ChebyshevSequence chebyshev(options.spectral_bound);
  std::int32_t batch_size =
      options.solver == Solver::Chebyshev ? first_batch_size(initial_error, options) : kBatchSteps;
  ProgressWatch watch(initial_error);
  result.stop_reason = StopReason::IterationLimit;
  while (result.iterations < options.max_iterations) {
    check_stop();
    std::vector<StepCoefficients> steps(
        static_cast<std::size_t>(std::min(batch_size, options.max_iterations - result.iterations)));
    for (StepCoefficients& step : steps) {
      step = options.solver == Solver::Chebyshev ? chebyshev.next() : StepCoefficients{0.0, 1.0};
    }
    const StepLog log = solve.run(steps, kStopMargin * options.tolerance);
    result.iterations += log.steps_taken;
    result.history.insert(result.history.end(), log.errors.begin(), log.errors.end());
    watch.tell(result, options);
    if (log.steps_taken < static_cast<std::int32_t>(steps.size())) {
      result.stop_reason = StopReason::Converged;
      return;
    }
    if (watch.diverged(log.errors.back().max)) {
      result.stop_reason = StopReason::Diverged;
      break;
    }
    if (watch.stagnates(log.errors)) {
      result.stop_reason = StopReason::Stagnated;
      break;
    }
    if (solve.error().max <= kStopMargin * options.tolerance) {
      result.stop_reason = StopReason::Converged;
      break;
    }
    batch_size = kBatchSteps;
  }
  result.history.push_back(solve.error());
}

namespace {

std::vector<glm::dvec3> by_gradients(Precision precision, const SummedView& limit_masks,
                                     std::span<const glm::dvec3> initial,
                                     const InterpolationOptions& options, Interpolation& result) {
  result.stop_reason = StopReason::IterationLimit;
  result.history = {result.error};
  if (options.max_iterations == 0) return std::vector<glm::dvec3>(initial.size(), glm::dvec3(0.0));
  check_stop();
  ProgressWatch watch(result.error.max);
  const auto ends = [&](StopReason reason) {
    result.stop_reason = reason;
    return false;
  };
  return conjugate_gradients(
      precision, limit_masks, initial, options.row_weights, [&](const ErrorNorms& error) {
        check_stop();
        ++result.iterations;
        result.history.push_back(error);
        watch.tell(result, options);
        if (error.max <= kStopMargin * options.tolerance) return ends(StopReason::Converged);
        if (watch.diverged(error.max)) return ends(StopReason::Diverged);
        const std::span<const ErrorNorms> history = result.history;
        if (result.iterations % kBatchSteps == 0 && watch.stagnates(history.last(kBatchSteps)))
          return ends(StopReason::Stagnated);
        return result.iterations < options.max_iterations;
      });
}

void check_options(const SummedView& masks, std::span<const glm::dvec3> given,
                   const InterpolationOptions& options) {
  PLANISH_ASSERT(masks.rows.row_count() == static_cast<std::int32_t>(given.size()));
  PLANISH_ASSERT(options.spectral_bound > 0 && options.spectral_bound < 1);
  if (!(options.tolerance > 0)) {
    throw Error(ErrorCode::InvalidArgument,
                "tolerance " + std::to_string(options.tolerance) + " is not above 0");
  }
  if (options.max_iterations < 0) {
    throw Error(ErrorCode::InvalidArgument,
                "maximum of iterations " + std::to_string(options.max_iterations) + " is below 0");
  }
}

}  // namespace

const char* name_of(StopReason reason) {
  switch (reason) {
    case StopReason::Converged:
      return "converged";
    case StopReason::IterationLimit:
      return "iteration-limit";
    case StopReason::Stagnated:
      return "stagnated";
    case StopReason::Singular:
      return "singular";
    case StopReason::Diverged:
      return "diverged";
  }
  return "unknown";
}

void conclude(const InterpolationOptions& options, Interpolation& result) {
  result.converged = result.error.max <= options.tolerance;
  if (!result.converged && result.stop_reason == StopReason::Converged) {
    result.stop_reason = StopReason::Stagnated;  // the device's precision ends above the tolerance
  }
}

namespace {

Interpolation solved(Backend& backend, const SummedView& limit_masks,
                     std::span<const glm::dvec3> given, const InterpolationOptions& options) {
  const RawVector<glm::dvec3> initial = initial_residual(limit_masks, given);
  Interpolation result;
  note_error(initial, result);
  if (result.error.max <= options.tolerance) {
    result.displacement.assign(given.size(), glm::dvec3(0.0));
    result.converged = true;
    result.history = {result.error};
    return result;
  }

  if (options.solver == Solver::ConjugateGradients) {
    result.displacement =
        by_gradients(backend.host_precision(), limit_masks, initial, options, result);
  } else {
    const auto before_upload = std::chrono::steady_clock::now();
    const std::unique_ptr<Solve> solve = backend.make_solve(limit_masks);
    const std::chrono::duration<double, std::milli> upload =
        std::chrono::steady_clock::now() - before_upload;
    result.upload_milliseconds = upload.count();
    solve->begin(initial);
    take_steps(*solve, result.error.max, options, result);
    result.displacement = solve->displacement();
  }
  note_error(residual_of(limit_masks, initial, result.displacement), result);
  conclude(options, result);
  return result;
}

}  // namespace

Interpolation interpolate(Backend& backend, const SummedView& limit_masks,
                          std::span<const glm::dvec3> given, const InterpolationOptions& options) {
  check_options(limit_masks, given, options);
  const HostScope host(options.callbacks);
  options.callbacks.report("solve", 0);
  Interpolation result;
  backend.run_on_host([&] { result = solved(backend, limit_masks, given, options); });
  options.callbacks.report("solve", 1);
  return result;
}

}  // namespace planish
