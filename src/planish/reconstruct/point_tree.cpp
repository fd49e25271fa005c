// Based on: J. L. Bentley, "Multidimensional Binary Search Trees Used for Associative Searching",
// 1975; laid out in one array as a balanced tree.
#include "planish/reconstruct/point_tree.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

namespace planish {
namespace {

constexpr std::int32_t kPointsOfLeaf = 12;

}  // namespace

struct PointTree::Search {
  glm::dvec3 query;
  std::span<Neighbour> nearest;
  std::size_t count = 0;

  [[nodiscard]] bool wants(double squared_distance) const {
    return count < nearest.size() || squared_distance < nearest[count - 1].squared_distance;
  }
  void offer(double squared_distance, std::int32_t index) {
    if (!wants(squared_distance)) return;
    std::size_t at = count < nearest.size() ? count++ : count - 1;
    for (; at > 0 && nearest[at - 1].squared_distance > squared_distance; --at)
      nearest[at] = nearest[at - 1];
    nearest[at] = {squared_distance, index};
  }
};

PointTree::PointTree(std::span<const glm::dvec3> points)
    : indices_(points.size()), points_(points.begin(), points.end()), axes_(points.size(), 0) {
  std::iota(indices_.begin(), indices_.end(), 0);
  build(0, static_cast<std::int32_t>(points.size()));
  for (std::size_t i = 0; i < indices_.size(); ++i) points_[i] = points[indices_[i]];
}

// While the tree is built, points_ still has the order of the input.
void PointTree::build(std::int32_t begin, std::int32_t end) {
  if (end - begin <= kPointsOfLeaf) return;
  glm::dvec3 low = points_[indices_[begin]], high = low;
  for (std::int32_t i = begin + 1; i < end; ++i) {
    low = glm::min(low, points_[indices_[i]]);
    high = glm::max(high, points_[indices_[i]]);
  }
  const glm::dvec3 extent = high - low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::int32_t middle = begin + (end - begin) / 2;
  // Ties are broken by index: the tree does not depend on the library's nth_element.
  std::nth_element(indices_.begin() + begin, indices_.begin() + middle, indices_.begin() + end,
                   [&](std::int32_t a, std::int32_t b) {
                     const double x = points_[a][axis], y = points_[b][axis];
                     return x < y || (x == y && a < b);
                   });
  axes_[middle] = static_cast<std::uint8_t>(axis);
  build(begin, middle);
  build(middle + 1, end);
}

void PointTree::search(std::int32_t begin, std::int32_t end, Search& state) const {
  const auto offer = [&](std::int32_t at) {
    const glm::dvec3 difference = points_[at] - state.query;
    state.offer(glm::dot(difference, difference), indices_[at]);
  };
  if (end - begin <= kPointsOfLeaf) {
    for (std::int32_t at = begin; at < end; ++at) offer(at);
    return;
  }
  const std::int32_t middle = begin + (end - begin) / 2;
  const double beyond = state.query[axes_[middle]] - points_[middle][axes_[middle]];
  beyond < 0 ? search(begin, middle, state) : search(middle + 1, end, state);
  if (!state.wants(beyond * beyond)) return;
  offer(middle);
  beyond < 0 ? search(middle + 1, end, state) : search(begin, middle, state);
}

std::size_t PointTree::find_nearest(const glm::dvec3& query, std::span<Neighbour> nearest) const {
  Search state{.query = query, .nearest = nearest};
  if (!nearest.empty()) search(0, static_cast<std::int32_t>(points_.size()), state);
  return state.count;
}

}  // namespace planish
