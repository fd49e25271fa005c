#include "planish/edit/followers.h"

#include <algorithm>
#include <cstddef>
#include <unordered_map>

namespace planish {
namespace {

template <class Place>
glm::dvec3 mean_of(const AddedVertex& added, const Place& place) {
  glm::dvec3 mean(0.0);
  for (int i = 0; i < 3; ++i) mean += added.weights[i] * place(added.vertices[i]);
  return mean;
}

}  // namespace

Followers::Followers(std::span<const AddedVertex> added, std::span<const glm::dvec3> positions)
    : added_(added.begin(), added.end()) {
  if (added.empty()) return;
  const std::int32_t leaders = leader_count(positions.size());
  const auto place = [&](std::int32_t v) { return positions[v]; };
  starts_.assign(static_cast<std::size_t>(leaders) + 1, 0);
  for (std::size_t i = 0; i < added.size(); ++i) {
    offsets_.push_back(positions[leaders + i] - mean_of(added[i], place));
    for (const std::int32_t v : added[i].vertices) ++starts_[v + 1];
  }
  for (std::int32_t v = 0; v < leaders; ++v) starts_[v + 1] += starts_[v];
  led_by_.resize(static_cast<std::size_t>(starts_.back()));
  std::vector<std::int32_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t i = 0; i < added.size(); ++i)
    for (const std::int32_t v : added[i].vertices)
      led_by_[next[v]++] = static_cast<std::int32_t>(i);
}

void Followers::follow(std::span<const glm::dvec3> positions, std::vector<std::int32_t>& vertices,
                       std::vector<glm::dvec3>& to) const {
  if (empty()) return;
  const std::int32_t leaders = leader_count(positions.size());
  std::unordered_map<std::int32_t, glm::dvec3> moved;  // of a vertex named twice the last counts
  for (std::size_t i = 0; i < vertices.size(); ++i) moved[vertices[i]] = to[i];
  std::vector<std::int32_t> following;
  for (const std::int32_t v : vertices)
    following.insert(following.end(), led_by_.begin() + starts_[v],
                     led_by_.begin() + starts_[v + 1]);
  std::ranges::sort(following);
  following.erase(std::unique(following.begin(), following.end()), following.end());
  const auto place = [&](std::int32_t v) {
    const auto found = moved.find(v);
    return found == moved.end() ? positions[v] : found->second;
  };
  for (const std::int32_t i : following) {
    vertices.push_back(leaders + i);
    to.push_back(mean_of(added_[i], place) + offsets_[i]);
  }
}

}  // namespace planish
