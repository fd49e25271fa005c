// Based on: Bentley, "Multidimensional binary search trees used for associative searching", 1975.
#include "planish/mesh/reflex_corners.h"

#include <algorithm>
#include <bit>
#include <glm/common.hpp>
#include <utility>

#include "planish/core/work.h"
#include "planish/mesh/plane.h"

namespace planish {
namespace {

constexpr std::uint32_t kLeaf = 16;  // so many are looked at one by one

// Whether some place in a box may lie on the left of the way from a to b, or on it. Rounding keeps
// the order of what it rounds, so that turn() of no place in the box is larger than this.
bool may_be_left(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& low,
                 const glm::dvec2& high) {
  return turn(a, b, {b.y >= a.y ? low.x : high.x, b.x >= a.x ? high.y : low.y}) >= 0;
}

bool is_in(const std::array<glm::dvec2, 3>& triangle, const glm::dvec2& place) {
  const auto& [a, b, c] = triangle;
  if (place == a || place == b || place == c) return false;
  return turn(a, b, place) >= 0 && turn(b, c, place) >= 0 && turn(c, a, place) >= 0;
}

}  // namespace

ReflexCorners::ReflexCorners(std::span<const glm::dvec2> places, std::vector<std::uint32_t> corners)
    : places_(places), corners_(std::move(corners)) {
  if (corners_.empty()) return;
  const auto count = static_cast<std::uint32_t>(corners_.size());
  nodes_.resize(2 * std::bit_ceil((count + kLeaf - 1) / kLeaf) - 1);
  leaf_of_.assign(places.size(), kNone);
  split(0, 0, count);
}

void ReflexCorners::split(std::size_t node, std::uint32_t begin, std::uint32_t end) {
  const auto own = std::span(corners_).subspan(begin, end - begin);
  glm::dvec2 low = places_[own[0]], high = low;
  for (const std::uint32_t corner : own) {
    low = glm::min(low, places_[corner]);
    high = glm::max(high, places_[corner]);
  }
  nodes_[node] = {low, high, begin, end, end - begin};
  if (2 * node + 2 >= nodes_.size()) {
    for (const std::uint32_t corner : own) leaf_of_[corner] = static_cast<std::uint32_t>(node);
    return;
  }
  const int axis = high.x - low.x >= high.y - low.y ? 0 : 1;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(
      own.begin(), own.begin() + (middle - begin), own.end(),
      [&](std::uint32_t a, std::uint32_t b) { return places_[a][axis] < places_[b][axis]; });
  split(2 * node + 1, begin, middle);
  split(2 * node + 2, middle, end);
}

void ReflexCorners::erase(std::uint32_t corner) {
  if (leaf_of_.empty() || leaf_of_[corner] == kNone) return;
  std::size_t node = std::exchange(leaf_of_[corner], kNone);
  Node& leaf = nodes_[node];
  const auto first = corners_.begin() + leaf.begin;
  std::iter_swap(std::find(first, first + leaf.left, corner), first + leaf.left - 1);
  for (;; node = (node - 1) / 2) {
    --nodes_[node].left;
    if (node == 0) break;
  }
}

std::uint32_t ReflexCorners::inside(const std::array<glm::dvec2, 3>& triangle) const {
  if (nodes_.empty()) return kNone;
  std::int64_t asked = 0;
  const std::uint32_t found = inside(0, triangle, asked);
  count_work(Work::Pairs, asked);
  return found;
}

std::uint32_t ReflexCorners::inside(std::size_t node, const std::array<glm::dvec2, 3>& triangle,
                                    std::int64_t& asked) const {
  ++asked;
  const Node& own = nodes_[node];
  if (own.left == 0) return kNone;
  const auto& [a, b, c] = triangle;
  if (!may_be_left(a, b, own.low, own.high) || !may_be_left(b, c, own.low, own.high) ||
      !may_be_left(c, a, own.low, own.high))
    return kNone;
  if (2 * node + 2 < nodes_.size()) {
    const std::uint32_t found = inside(2 * node + 1, triangle, asked);
    return found != kNone ? found : inside(2 * node + 2, triangle, asked);
  }
  asked += own.left;
  for (std::uint32_t k = own.begin; k < own.begin + own.left; ++k)
    if (is_in(triangle, places_[corners_[k]])) return corners_[k];
  return kNone;
}

}  // namespace planish
