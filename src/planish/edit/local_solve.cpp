// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3.2: the
// iteration is local. Here by relaxation of single rows (Southwell 1946, in the order of a queue),
// which converges wherever B is positive definite in some scalar product.
#include "planish/edit/local_solve.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "planish/backend/cpu_backend.h"
#include "planish/backend/initial_residual.h"
#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/number_text.h"
#include "planish/core/parallel.h"
#include "planish/core/stop.h"

namespace planish {

namespace {

// Of the tolerance: what moves solve to, so that control points, which are off by up to four times
// the residual on quads, stay within the tolerance of those of a solve from scratch; and what a
// solve of all rows goes to, so that many moves find room below that.
constexpr double kLocalShare = 0.125, kSettledShare = 0.0625;

// Of a row's residual, divided by its own weight, what is taken as step: a little more than all, as
// residuals beside each other mostly have one sign. The bound does not depend on it.
constexpr double kRelaxation = 1.15;

// Where a move is expected to touch more than that part of all vertices, and so many, all rows are
// solved and evaluated at less cost.
constexpr std::size_t kWholeShare = 16, kFewVertices = 512;

// By what a change shrinks from one vertex to the next along edges: of quads 3 - 2 sqrt(2), by
// which (1, 6, 1) / 8 is inverted. Measured, it goes as far over a triangle as over 3/4 of a quad,
// over an octagon as over two.
constexpr double kDecay = 0.1716, kQuadSize = 4;

// What a moved vertex hardly ever goes beyond.
constexpr std::size_t kMostReached = 512;

// How far what is touched may go beyond what was expected.
constexpr double kMostExcess = 1.5;

// A move that looks at so many rows for each vertex of the mesh does not converge by itself.
constexpr std::int64_t kMostLooks = 64;

constexpr std::size_t kSolveGrain = 4096;

}  // namespace

LocalSolve::LocalSolve(LimitSystem system, std::shared_ptr<const MeshTopology> topology,
                       std::vector<glm::dvec3> given, std::vector<glm::dvec3> control,
                       double tolerance, const Callbacks& callbacks)
    : system_(std::move(system)),
      topology_(std::move(topology)),
      given_(std::move(given)),
      control_(std::move(control)),
      tolerance_(tolerance),
      touched_(topology_->vertex_count()),
      fresh_faces_(0),
      is_queued_(given_.size(), 0) {
  if (const std::int32_t count = system_.masks.view().sum_count(); count > 0) {
    for (std::int32_t f = 0; f < topology_->face_count(); ++f)
      if (topology_->face_size(f) >= kSummedRing) large_faces_.push_back(f);
    sums_per_face_ = count / static_cast<std::int32_t>(large_faces_.size());
    fresh_faces_ = SparseSet(static_cast<std::int32_t>(large_faces_.size()));
  }
  settle(callbacks);
}

glm::dvec3 LocalSolve::residual(std::int32_t row) const {
  const StencilTable& rows = system_.masks.rows;
  const auto count = static_cast<std::int32_t>(control_.size());
  glm::dvec3 result = given_[row];
  const std::int32_t first = rows.offsets[row];
  for (std::int32_t k = first; k < first + rows.sizes[row]; ++k) {
    const std::int32_t source = rows.indices[k];
    result -= rows.weights[k] * (source < count ? control_[source] : sums_[source - count]);
  }
  return result;
}

std::int32_t LocalSolve::first_sum_of(std::int32_t face) const {
  const auto found = std::ranges::lower_bound(large_faces_, face);
  return sums_per_face_ * static_cast<std::int32_t>(found - large_faces_.begin());
}

// Sums follow steps one by one; made anew once a move, they keep the bits of one.
void LocalSolve::refresh_sums_at(std::int32_t vertex) {
  const StencilTable& table = system_.masks.sums;
  for (const std::int32_t corner : topology_->corners_at(vertex)) {
    const std::int32_t face = topology_->face_of(corner);
    if (topology_->face_size(face) < kSummedRing) continue;
    const std::int32_t first = first_sum_of(face);
    if (!fresh_faces_.add(first / sums_per_face_)) continue;
    for (std::int32_t s = first; s < first + sums_per_face_; ++s) {
      glm::dvec3 sum(0.0);
      for (std::int32_t k = table.offsets[s]; k < table.offsets[s] + table.sizes[s]; ++k)
        sum += table.weights[k] * control_[table.indices[k]];
      sums_[s] = sum;
    }
  }
}

void LocalSolve::touch(std::int32_t vertex) {
  if (touched_.contains(vertex)) return;
  const auto at = static_cast<std::size_t>(vertex);
  before_.push_back({given_[at], control_[at]});
  touched_.add(vertex);
  if (!large_faces_.empty()) refresh_sums_at(vertex);
}

void LocalSolve::wake(std::int32_t vertex) {
  if (is_queued_[vertex] != 0) return;
  queue_.push_back(vertex);
  is_queued_[vertex] = 1;
}

// Rows that name a vertex are of vertices of its faces.
void LocalSolve::shift(std::int32_t vertex, const glm::dvec3& step) {
  touch(vertex);
  control_[vertex] += step;
  wake(vertex);
  for (const std::int32_t corner : topology_->corners_at(vertex)) {
    const std::int32_t face = topology_->face_of(corner);
    for (const std::int32_t other : topology_->face(face)) wake(other);
    if (topology_->face_size(face) < kSummedRing || large_faces_.empty()) continue;
    const StencilTable& table = system_.masks.sums;
    const std::int32_t first = first_sum_of(face);
    for (std::int32_t s = first; s < first + sums_per_face_; ++s)
      sums_[s] += table.weights[table.offsets[s] + topology_->place_of(corner)] * step;
  }
}

std::size_t LocalSolve::most_touched() const {
  return std::max(kFewVertices, control_.size() / kWholeShare);
}

// Counts the vertices that are as near to moved ones, along edges, as changes go that begin with
// their ways, and stops where these are too many: some hundredths of what relaxing them costs.
bool LocalSolve::reaches_many(std::span<const std::int32_t> vertices,
                              std::span<const glm::dvec3> points) {
  const std::size_t most = most_touched();
  if (vertices.size() > most) return true;
  if (vertices.size() * kMostReached <= most) return false;
  SparseSet& reached = touched_;  // which is empty as yet, and is left so
  for (auto& ring : rings_) ring.clear();
  const auto enter = [&](std::int32_t vertex, long rings) {
    const auto left = static_cast<std::size_t>(rings);
    if (rings_.size() <= left) rings_.resize(left + 1);
    rings_[left].push_back(vertex);
  };
  const double face_size = static_cast<double>(topology_->corner_count()) / topology_->face_count();
  const double rings_per_e = face_size / kQuadSize / -std::log(kDecay);
  constexpr double kMostRings = 64;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const double way = glm::length(points[i] - given_[vertices[i]]);
    const double rings = std::log(way / bound_) * rings_per_e;  // of none: below 0
    enter(vertices[i], rings > 0 ? std::lround(std::min(rings, kMostRings)) : 0);
  }
  for (std::size_t left = rings_.size(); left-- > 0 && reached.members().size() <= most;) {
    for (std::size_t i = 0; i < rings_[left].size() && reached.members().size() <= most; ++i) {
      const std::int32_t vertex = rings_[left][i];
      if (!reached.add(vertex)) continue;
      if (left == 0) continue;
      for (const std::int32_t corner : topology_->corners_at(vertex))
        for (const std::int32_t other : {topology_->next(corner), topology_->prev(corner)})
          if (const std::int32_t v = topology_->vertex_of(other); !reached.contains(v))
            rings_[left - 1].push_back(v);
    }
  }
  const bool reaches_many = reached.members().size() > most;
  reached.clear();
  return reaches_many;
}

// False where it does not come to an end, or all rows are better solved.
bool LocalSolve::relax() {
  const double least = bound_ * bound_;
  const auto most_vertices =
      static_cast<std::size_t>(kMostExcess * static_cast<double>(most_touched()));
  const std::int64_t most = kMostLooks * static_cast<std::int64_t>(control_.size());
  const StencilTable& rows = system_.masks.rows;
  StopCheck stop;
  std::size_t next = 0;
  while (next < queue_.size()) {
    stop.step();
    if (++row_count_ > most || touched_.members().size() > most_vertices) return false;
    const std::int32_t row = queue_[next++];
    is_queued_[row] = 0;
    // What has been looked at is dropped, at less cost than that of the looks.
    if (next > 1024 && 2 * next > queue_.size()) {
      queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(next));
      next = 0;
    }
    const glm::dvec3 left = residual(row);
    const double square = glm::dot(left, left);
    if (square <= least) continue;
    if (!std::isfinite(square)) return false;
    double own = 0;
    const std::int32_t first = rows.offsets[row];
    for (std::int32_t k = first; k < first + rows.sizes[row]; ++k)
      if (rows.indices[k] == row) own = rows.weights[k];
    // Rows of corners name their vertex alone: they are met at once.
    const double share = rows.sizes[row] == 1 ? 1.0 : kRelaxation / std::max(own, 0.25);
    shift(row, share * left);
  }
  queue_.clear();
  return true;
}

void LocalSolve::take_back() {
  for (const std::int32_t row : queue_) is_queued_[row] = 0;
  queue_.clear();
  const auto members = touched_.members();
  for (std::size_t i = 0; i < members.size(); ++i) {
    const auto at = static_cast<std::size_t>(members[i]);
    given_[at] = before_[i].given;
    control_[at] = before_[i].control;
  }
  fresh_faces_.clear();
  for (const std::int32_t vertex : members) refresh_sums_at(vertex);
}

void LocalSolve::move(std::span<const std::int32_t> vertices, std::span<const glm::dvec3> points) {
  touched_.clear();
  before_.clear();
  fresh_faces_.clear();
  row_count_ = 0;
  changed_all_ = false;
  const bool is_local = !reaches_many(vertices, points);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    touch(vertices[i]);
    const auto at = static_cast<std::size_t>(vertices[i]);
    // The surface goes along, to first order: half of the way is saved.
    const glm::dvec3 way = points[i] - given_[at];
    given_[at] = points[i];
    if (is_local)
      shift(vertices[i], way);
    else
      control_[at] += way;
  }
  try {
    if (!is_local || !relax()) {
      for (const std::int32_t row : queue_) is_queued_[row] = 0;
      queue_.clear();
      settle();
    }
  } catch (...) {
    take_back();
    throw;
  }
}

void LocalSolve::settle(const Callbacks& callbacks) {
  const std::vector<glm::dvec3> before = control_;
  try {
    const auto backend = make_cpu_backend();
    const SummedView masks = system_.masks.view();
    sums_ = sums_of(masks, control_);
    std::vector<glm::dvec3> left(control_.size());
    parallel_each(left.size(), kSolveGrain, [&](std::int32_t v) { left[v] = residual(v); });
    double longest = 0;
    for (const glm::dvec3& r : left) longest = std::max(longest, glm::length(r));
    InterpolationOptions options;
    options.tolerance = kSettledShare * tolerance_;
    options.spectral_bound = system_.spectral_bound;
    options.max_iterations = 1000;
    options.callbacks = callbacks;
    if (longest > options.tolerance) {
      const std::unique_ptr<Solve> solve = backend->make_solve(masks);
      solve->begin(left);
      Interpolation result;
      take_steps(*solve, longest, options, result);
      const std::vector<glm::dvec3> steps = solve->displacement();
      parallel_each(steps.size(), kSolveGrain, [&](std::size_t v) { control_[v] += steps[v]; });
      sums_ = sums_of(masks, control_);
      longest = measured().norms.max;
    }
    if (!(longest <= tolerance_)) {
      throw Error(ErrorCode::InvalidArgument,
                  formatted("the equations of this mesh are solved to {} of the diagonal, the "
                            "tolerance is {}; take a larger tolerance, or fair interpolation",
                            shortest(longest), shortest(tolerance_)));
    }
    // Where rounding ends above the tolerance's share, moves end there as well.
    bound_ = std::max(kLocalShare * tolerance_, 2 * longest);
    changed_all_ = true;
  } catch (...) {
    control_ = before;
    sums_ = sums_of(system_.masks.view(), control_);
    throw;
  }
}

MeasuredError LocalSolve::measured() const {
  return measure_error(control_.size(), [&](std::int32_t v) { return residual(v); });
}

}  // namespace planish
