// Based on: M. Garland, P. Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997
// (the order of collapses); L. Kobbelt, S. Campagna, H.-P. Seidel, "A General Framework for Mesh
// Decimation", 1998 (half-edge collapses under a bound on the distance of the removed points).
#include "planish/reconstruct/collapse_pass.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>

#include "planish/core/parallel.h"

namespace planish {
namespace {

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

}  // namespace planish
