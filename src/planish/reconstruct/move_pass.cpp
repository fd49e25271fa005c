// Based on: the smoothing of meshes by moving each vertex to the mean of its neighbours, within the
// surface (D. A. Field, "Laplacian Smoothing and Delaunay Triangulations", 1988), among the
// samples.
#include "planish/reconstruct/move_pass.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

namespace planish {
namespace {

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

}  // namespace planish
