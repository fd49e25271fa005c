// Based on: N. Dyn, D. Levin, S. Rippa, "Data Dependent Triangulations for Piecewise Linear
// Interpolation", 1990 (edges are chosen by what the surface does, not by angles alone).
#include "planish/reconstruct/flip_pass.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace planish {
namespace {

constexpr int kMostSweeps = 3;
// What a smallest angle wider by one radian may cost: the mean of 1 - cosine of the angles between
// triangles and samples. Without it the triangles are slivers where the shape is a cylinder; ten
// times as much leaves 3 % more vertices.
constexpr double kAngleWeight = 0.01;
// Less is rounding.
constexpr double kLeastGain = 1e-5;

double smallest_angle(const TriangleQuality& quality) {
  return std::acos(std::min(quality.largest_cosine, 1.0));
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

}  // namespace planish
