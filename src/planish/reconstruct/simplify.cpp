#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <string>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/reconstruct/reconstruct_steps.h"
#include "planish/reconstruct/simplify_state.h"

namespace planish {
namespace {

// Based on: M. Garland, P. Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997
// (the order of collapses); L. Kobbelt, S. Campagna, H.-P. Seidel, "A General Framework for Mesh
// Decimation", 1998 (half-edge collapses under a bound on the distance of the removed points).

// A quadric's mean distance beyond this many tolerances cannot be mended by a nearer triangle
// often enough to be worth the look at the points.
constexpr double kHopelessTolerances = 4.0;
// Among collapses that cost next to nothing the shorter goes first: an edge of a hundred tolerances
// counts as an error of one.
constexpr double kLengthWeight = 1e-4;
constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr std::size_t kCollapseGrain = 4096;

}  // namespace

double CollapsePass::cost_of(std::int32_t vertex, std::int32_t target) const {
  const Quadric& quadric = state_.quadrics[vertex];
  const glm::dvec3& place = state_.positions[target];
  const double limit = state_.options.tolerance * kHopelessTolerances;
  const double error = quadric.at(place);
  if (error > quadric.weight * limit * limit) return kNever;
  const glm::dvec3 edge = place - state_.positions[vertex];
  const double squared_length = glm::dot(edge, edge);
  return state_.options.spacing == Spacing::Even
             ? squared_length
             : error + kLengthWeight * quadric.weight * squared_length;
}

double CollapsePass::least_cost(std::int32_t vertex) const {
  double least = kNever;
  state_.mesh.for_each_neighbour(
      vertex, [&](std::int32_t other) { least = std::min(least, cost_of(vertex, other)); });
  return least;
}

// In parallel, for costs are most of the work where few collapses are left.
void CollapsePass::fill_queue() {
  std::vector<Entry> entries;
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(waiting_.size()); ++v)
    if (state_.take(v, Pass::Collapse)) entries.push_back({0, v, 0});
  parallel_each(entries.size(), kCollapseGrain, [&](std::size_t i) {
    Entry& entry = entries[i];
    Waiting& waiting = waiting_[entry.vertex];
    waiting.cost = entry.cost = least_cost(entry.vertex);
    entry.version = ++waiting.version;
  });
  std::erase_if(entries, [](const Entry& entry) { return entry.cost == kNever; });
  queue_ = std::priority_queue<Entry>({}, std::move(entries));
}

void CollapsePass::push(std::int32_t vertex, double cost) {
  Waiting& waiting = waiting_[vertex];
  waiting.cost = cost;
  ++waiting.version;
  if (cost != kNever) queue_.push({cost, vertex, waiting.version});
}

// Fills fan_ and candidates_, the cheapest first.
void CollapsePass::list_candidates(std::int32_t vertex) {
  state_.mesh.get_fan(vertex, fan_);
  candidates_.clear();
  for (std::size_t target = 0; target < fan_.ring.size(); ++target) {
    // A boundary vertex runs along the boundary.
    if (!fan_.closed && target != 0 && target + 1 != fan_.ring.size()) continue;
    const double cost = cost_of(vertex, fan_.ring[target]);
    if (cost != kNever) candidates_.push_back({cost, target});
  }
  std::ranges::sort(candidates_, [](const Candidate& a, const Candidate& b) {
    return a.cost < b.cost || (a.cost == b.cost && a.target < b.target);
  });
}

void CollapsePass::run() {
  for (fill_queue(); !queue_.empty() && !state_.is_done();) {
    const Entry entry = queue_.top();
    queue_.pop();
    if (entry.version != waiting_[entry.vertex].version || !state_.mesh.is_used(entry.vertex))
      continue;
    state_.count_step();
    collapse_best(entry);
  }
}

// Of the targets that cost at least as much as the entry: the cheaper ones were in vain.
void CollapsePass::collapse_best(const Entry& entry) {
  waiting_[entry.vertex].cost = kNever;
  (void)state_.take(entry.vertex, Pass::Collapse);
  list_candidates(entry.vertex);
  for (const auto& [cost, target] : candidates_) {
    if (cost < entry.cost) continue;
    if (!queue_.empty() && cost > queue_.top().cost) {
      push(entry.vertex, cost);  // a dearer target waits for its turn
      return;
    }
    if (!try_collapse(entry.vertex, target)) continue;
    apply(entry.vertex, target);
    return;
  }
}

bool CollapsePass::keeps_valences(std::int32_t vertex, std::size_t target) const {
  const CollapseMesh& mesh = state_.mesh;
  const std::size_t count = fan_.ring.size();
  const std::int32_t lost = fan_.closed ? 4 : 3;
  const std::int32_t valence = mesh.valence(vertex) + mesh.valence(fan_.ring[target]) - lost;
  if (valence > state_.max_valence) return false;
  const auto stays = [&](std::size_t at) {
    const std::int32_t v = fan_.ring[at % count];
    return mesh.is_boundary(v) || mesh.valence(v) > SimplifyState::kLeastInnerValence;
  };
  if (!mesh.is_boundary(fan_.ring[target]) && valence < SimplifyState::kLeastInnerValence)
    return false;
  if (fan_.closed) return stays(target + 1) && stays(target + count - 1);
  return stays(target == 0 ? 1 : count - 2);
}

// Fills change_.
bool CollapsePass::keeps_shape(std::int32_t vertex, std::size_t target) {
  const std::int32_t other = fan_.ring[target];
  const std::size_t count = fan_.ring.size();
  change_.clear();
  change_.removed_vertex = vertex;
  TriangleQuality after;
  for (std::size_t i = 0; i < fan_.spokes.size(); ++i) {
    const std::int32_t a = fan_.ring[i], b = fan_.ring[(i + 1) % count];
    change_.old_slots.push_back(fan_.spokes[i] / 3);
    if (a == other || b == other) continue;
    after.take_worst(state_.judge.quality(other, a, b));
    change_.triangles.push_back({other, a, b});
    change_.slots.push_back(fan_.spokes[i] / 3);
  }
  return state_.allows(after, [&] { return state_.worst_of(fan_); });
}

bool CollapsePass::try_collapse(std::int32_t vertex, std::size_t target) {
  return state_.mesh.can_collapse(vertex, fan_, target) && keeps_valences(vertex, target) &&
         keeps_shape(vertex, target) && state_.gradation.keeps_all(vertex, fan_, target) &&
         state_.carried.can_move(change_);
}

void CollapsePass::apply(std::int32_t vertex, std::size_t target) {
  const std::int32_t other = fan_.ring[target];
  state_.mesh.collapse(vertex, fan_, target);
  state_.carried.move(change_);
  state_.quadrics[other].add(state_.quadrics[vertex]);
  --state_.result.vertex_count;
  ++state_.result.collapse_count;
  // Those around the target may have found a way that was barred: the next run looks at them.
  state_.mesh.for_each_neighbour(other, [&](std::int32_t n) { state_.touch(n); });
  state_.touch(other);
  push(other, least_cost(other));
  for (const std::int32_t rim : fan_.ring) {
    if (rim == other) continue;
    // The target is new to the rim. What it was waiting for may be gone: it finds out in its turn.
    if (const double cost = cost_of(rim, other); cost < waiting_[rim].cost) push(rim, cost);
  }
}

namespace {

// Based on: N. Dyn, D. Levin, S. Rippa, "Data Dependent Triangulations for Piecewise Linear
// Interpolation", 1990 (edges are chosen by what the surface does, not by angles alone).

constexpr int kMostSweeps = 3;
// What a smallest angle wider by one radian may cost: the mean of 1 - cosine of the angles between
// triangles and samples. Without it the triangles are slivers where the shape is a cylinder; ten
// times as much leaves 3 % more vertices.
constexpr double kAngleWeight = 0.01;
// Less is rounding.
constexpr double kLeastGain = 1e-5;

double smallest_angle(const TriangleQuality& quality) {
  return portable::acos(std::min(quality.largest_cosine, 1.0));
}

}  // namespace

bool FlipPass::keeps_valences(const Diamond& diamond) const {
  const auto [a, b, c, d] = diamond;
  const CollapseMesh& mesh = state_.mesh;
  const auto can_lose = [&](std::int32_t v) {
    return mesh.is_boundary(v) || mesh.valence(v) > SimplifyState::kLeastInnerValence;
  };
  return can_lose(a) && can_lose(b) && mesh.valence(c) < state_.max_valence &&
         mesh.valence(d) < state_.max_valence;
}

bool FlipPass::gains(const Diamond& diamond) const {
  const auto [a, b, c, d] = diamond;
  const ShapeJudge& judge = state_.judge;
  TriangleQuality before = judge.quality(a, b, c), after = judge.quality(c, d, b);
  before.take_worst(judge.quality(b, a, d));
  after.take_worst(judge.quality(d, c, a));
  if (!state_.allows(after, [&] { return before; })) return false;
  const auto& at = state_.positions;
  const double area = glm::length(glm::cross(at[b] - at[a], at[d] - at[c]));
  const double closer = judge.deviation(a, b, c) + judge.deviation(b, a, d) -
                        judge.deviation(c, d, b) - judge.deviation(d, c, a);
  const double wider = smallest_angle(after) - smallest_angle(before);
  return closer + area * (kAngleWeight * wider - kLeastGain) > 0;
}

bool FlipPass::try_flip(std::int32_t half_edge) {
  CollapseMesh& mesh = state_.mesh;
  const std::int32_t twin = mesh.twin(half_edge);
  if (twin < 0) return false;
  const Diamond diamond{mesh.start(half_edge), mesh.end(half_edge),
                        mesh.end(next_half_edge(half_edge)), mesh.end(next_half_edge(twin))};
  const auto [a, b, c, d] = diamond;
  if (!keeps_valences(diamond) || !gains(diamond) || !mesh.can_flip(half_edge)) return false;
  // a and b lose an edge, which makes no ratio worse.
  const auto& at = state_.positions;
  if (!state_.gradation.keeps(c, {.with = &at[d]}) || !state_.gradation.keeps(d, {.with = &at[c]}))
    return false;
  change_.clear();
  change_.old_slots = change_.slots = {half_edge / 3, twin / 3};
  change_.triangles = {{c, d, b}, {d, c, a}};
  if (!state_.carried.can_move(change_)) return false;
  mesh.flip(half_edge);
  state_.carried.move(change_);
  for (const std::int32_t v : diamond) state_.touch(v);
  ++state_.result.flip_count;
  return true;
}

void FlipPass::run() {
  const auto count = static_cast<std::int32_t>(state_.positions.size());
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    const std::int64_t before = state_.result.flip_count;
    for (std::int32_t v = 0; v < count; ++v) {
      if (!state_.take(v, Pass::Flip)) continue;
      state_.count_step();
      state_.mesh.get_fan(v, fan_);
      for (const std::int32_t spoke : fan_.spokes) {
        // Once an edge, unless its other end is not due.
        const std::int32_t other = state_.mesh.end(spoke);
        if (v < other && state_.waits(other, Pass::Flip)) continue;
        if (try_flip(spoke)) break;  // the fan has changed; the vertex is due again
      }
    }
    if (state_.result.flip_count == before) break;
  }
}

namespace {

// Based on: the smoothing of meshes by moving each vertex to the mean of its neighbours, within the
// surface (D. A. Field, "Laplacian Smoothing and Delaunay Triangulations", 1988), among the
// samples.

// A move has to bring this share of the squared distance to the middle, at most. Nearer to 1 more
// sweeps are needed for little.
constexpr double kLargestShare = 0.7;
constexpr std::size_t kMostTries = 3;

}  // namespace

// Fills samples_ with those nearer to the middle of the fan than the vertex, the nearest first, and
// what all moves have in common into change_.
void MovePass::list_samples(std::int32_t vertex) {
  glm::dvec3 middle(0.0);
  for (const std::int32_t rim : fan_.ring) middle += state_.positions[rim];
  middle /= static_cast<double>(fan_.ring.size());
  const glm::dvec3 normal = state_.judge.normal(vertex);
  const auto squared_offset = [&](const glm::dvec3& place) {
    const glm::dvec3 offset = place - middle;
    const double height = glm::dot(offset, normal);
    return glm::dot(offset, offset) - height * height;
  };
  change_.clear();
  change_.removed_vertex = vertex;
  inside_.clear();
  for (const std::int32_t spoke : fan_.spokes) {
    change_.old_slots.push_back(spoke / 3);
    state_.carried.list(spoke / 3, inside_);
  }
  change_.slots = change_.old_slots;
  samples_.clear();
  const double limit = kLargestShare * squared_offset(state_.positions[vertex]);
  for (const std::int32_t point : inside_)
    if (const double offset = squared_offset(state_.points[point]); offset < limit)
      samples_.emplace_back(offset, point);
  const std::size_t tries = std::min(samples_.size(), kMostTries);
  std::ranges::partial_sort(samples_, samples_.begin() + static_cast<std::ptrdiff_t>(tries));
  samples_.resize(tries);
}

bool MovePass::try_place(std::int32_t vertex, std::int32_t sample) {
  const std::size_t count = fan_.ring.size();
  const glm::dvec3 place = state_.points[sample];
  const JudgedCorner corner{place, state_.normal_of_point(sample)};
  TriangleQuality after;
  for (std::size_t i = 0; i < count; ++i)
    after.take_worst(state_.judge.quality(corner, state_.judge.corner(fan_.ring[i]),
                                          state_.judge.corner(fan_.ring[(i + 1) % count])));
  if (!state_.allows(after, [&] { return state_.worst_of(fan_); }) ||
      !state_.gradation.keeps_moved(vertex, place, fan_))
    return false;
  change_.added_point = sample;
  change_.triangles.clear();
  for (std::size_t i = 0; i < count; ++i)
    change_.triangles.push_back({vertex, fan_.ring[i], fan_.ring[(i + 1) % count]});
  const glm::dvec3 before = std::exchange(state_.positions[vertex], place);
  if (state_.carried.can_move(change_)) return true;
  state_.positions[vertex] = before;
  return false;
}

bool MovePass::try_move(std::int32_t vertex) {
  state_.mesh.get_fan(vertex, fan_);
  if (!fan_.closed) return false;
  list_samples(vertex);
  for (const auto& [offset, sample] : samples_) {
    if (!try_place(vertex, sample)) continue;
    state_.carried.move(change_);
    state_.vertex_points[vertex] = sample;
    state_.judge.set_normal(vertex, state_.normal_of_point(sample));
    state_.touch(vertex);
    for (const std::int32_t rim : fan_.ring) state_.touch(rim);
    return true;
  }
  return false;
}

void MovePass::run() {
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(state_.positions.size()); ++v) {
    if (!state_.take(v, Pass::Move)) continue;
    state_.count_step();
    if (try_move(v)) ++state_.result.move_count;
  }
}

namespace {

// Each round's flips and moves give the next one's collapses room: with adaptive spacing the second
// takes 11 % of the vertices that the first leaves, the third 2 %, the fourth half a percent.
constexpr int kMostRounds = 12;
// A round that takes a smaller share is the last.
constexpr double kLeastShare = 0.002;
// Of the time that is left, what the first round takes, and what each of the others does.
constexpr double kFirstRound = 0.6, kFurtherRound = 0.5;

void check_simplify_options(const SimplifyOptions& options) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::InvalidArgument, what);
  };
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
    refuse("the tolerance of the mesh must be a positive length");
  if (options.least_angle > 45)
    refuse(formatted("min-angle: {} is not from 0 to 45 degrees",
                     std::to_string(options.least_angle)));
  if (options.max_valence >= 0 && options.max_valence < 6)
    refuse(formatted("max-valence: {} is below 6", options.max_valence));
  if (options.target_vertices < 0) refuse("target-vertices: a count from 0 is needed");
}

void run_rounds(SimplifyState& state) {
  CollapsePass collapses(state);
  FlipPass flips(state);
  MovePass moves(state);
  double done = 0;
  for (int round = 0; round < kMostRounds && !state.is_done(); ++round) {
    const double begun = done;
    done += (1 - done) * (round == 0 ? kFirstRound : kFurtherRound);
    state.begin_round(begun, done);
    const std::int64_t before = state.result.collapse_count;
    collapses.run();
    flips.run();
    moves.run();
    flips.run();
    const auto taken = static_cast<double>(state.result.collapse_count - before);
    if (taken < kLeastShare * static_cast<double>(state.result.vertex_count)) break;
  }
}

// The mesh with its vertices, and then its triangles, in the order of the points: the passes look
// at neighbours, which then are near in memory, too. All points without a vertex are carried.
WitnessedMesh in_order(const OrderedPoints& points, std::span<const Triangle> triangles) {
  std::vector<std::int32_t> vertex(points.size(), -1);  // of a point as it was given
  for (const Triangle& triangle : triangles)
    for (const std::int32_t corner : triangle) vertex[corner] = 0;
  WitnessedMesh mesh;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (vertex[points.given(i)] < 0) continue;
    vertex[points.given(i)] = static_cast<std::int32_t>(mesh.vertex_points.size());
    mesh.vertex_points.push_back(static_cast<std::int32_t>(i));
  }
  mesh.triangles.assign(triangles.begin(), triangles.end());
  for (Triangle& triangle : mesh.triangles) {
    for (std::int32_t& corner : triangle) corner = vertex[corner];
    std::ranges::rotate(triangle, std::ranges::min_element(triangle));
  }
  std::ranges::sort(mesh.triangles);
  return mesh;
}

}  // namespace

double default_least_angle(Spacing spacing) { return spacing == Spacing::Even ? 22.0 : 12.0; }

std::int32_t default_max_valence(Spacing spacing) { return spacing == Spacing::Even ? 8 : 10; }

SimplifiedMesh simplify(const OrderedPoints& points, WitnessedMesh mesh,
                        const SimplifyOptions& options) {
  check_simplify_options(options);
  const HostScope host(options.callbacks);
  options.callbacks.report("simplify", 0.0);
  SimplifyState state(points, std::move(mesh), options);
  run_rounds(state);
  SimplifiedMesh result = std::move(state.result);
  for (std::size_t t = 0; t < state.mesh.triangle_count(); ++t) {
    if (!state.mesh.is_alive(static_cast<std::int32_t>(t))) continue;
    Triangle triangle = state.mesh.triangle(static_cast<std::int32_t>(t));
    for (std::int32_t& corner : triangle) corner = state.vertex_points[corner];
    result.triangles.push_back(triangle);
  }
  options.callbacks.report("simplify", 1.0);
  return result;
}

SimplifiedMesh simplify(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                        const SimplifyOptions& options) {
  check_simplify_options(options);
  const OrderedPoints points(positions);
  WitnessedMesh mesh = in_order(points, triangles);
  LoopProgress progress(options.callbacks, "simplify", 0, 0, std::ssize(positions));
  const std::int64_t strayed_count =
      std::ssize(find_carriers(points, mesh, options.tolerance, options.tolerance, progress));
  SimplifiedMesh result = simplify(points, std::move(mesh), options);
  result.strayed_count = strayed_count;
  for (Triangle& triangle : result.triangles)
    for (std::int32_t& corner : triangle) corner = points.given(corner);
  return result;
}

}  // namespace planish
