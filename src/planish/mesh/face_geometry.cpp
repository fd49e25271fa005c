#include "planish/mesh/face_geometry.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <optional>
#include <queue>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "planish/core/guards.h"
#include "planish/core/work.h"

namespace planish {
namespace {

// The corners of a polygon that turn inward, to ask which of them lies in a triangle. A tree over
// their places, halved at the median: a question takes time of the order of the root of their
// number at most where it is answered by none, mostly of its logarithm.
class ReflexCorners {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  // `places`: of all corners of the polygon; must outlive it. `corners`: numbers of some of them.
  ReflexCorners(std::span<const glm::dvec2> places, std::vector<std::uint32_t> corners);

  // Nothing where it is none of them, or no longer.
  void erase(std::uint32_t corner);

  // One that lies in the triangle or on its sides, whose corners turn left; kNone: there is none.
  // Those at its corners do not count: they are the seam of a polygon that touches itself.
  [[nodiscard]] std::uint32_t inside(const std::array<glm::dvec2, 3>& triangle) const;

 private:
  struct Node {
    glm::dvec2 low, high;
    std::uint32_t begin, end, left;  // of corners_; `left`: how many are still there
  };
  void split(std::size_t node, std::uint32_t begin, std::uint32_t end);
  // `asked` counts nodes and corners.
  [[nodiscard]] std::uint32_t inside(std::size_t node, const std::array<glm::dvec2, 3>& triangle,
                                     std::int64_t& asked) const;

  std::span<const glm::dvec2> places_;
  std::vector<std::uint32_t> corners_;
  std::vector<Node> nodes_;             // the halves of node i are 2 i + 1 and 2 i + 2
  std::vector<std::uint32_t> leaf_of_;  // by corner of the polygon; kNone: not among them
};

// Based on: Bentley, "Multidimensional binary search trees used for associative searching", 1975.

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
  std::nth_element(own.begin(), own.begin() + (middle - begin), own.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     return std::pair(places_[a][axis], a) < std::pair(places_[b][axis], b);
                   });
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

// Based on: Meisters, "Polygons have ears", 1975.

constexpr std::uint32_t kNoCorner = ReflexCorners::kNone;

// In the order of sizes, by so many bits after the first: equal where rounding alone differs.
std::uint32_t rounded(double size, int bits) {
  const int dropped = 23 - bits;
  const double most = std::numeric_limits<float>::max();
  const auto all = std::bit_cast<std::uint32_t>(static_cast<float>(std::min(std::abs(size), most)));
  return (all + (1U << (dropped - 1))) >> dropped;
}

// What is left of a polygon while ears are cut off.
class Ears {
 public:
  explicit Ears(std::span<const glm::dvec2> flat) : flat_(flat), corners_(flat.size()) {
    const auto count = static_cast<std::uint32_t>(flat.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      corners_[i].next = i + 1 < count ? i + 1 : 0;
      corners_[i].previous = i > 0 ? i - 1 : count - 1;
    }
    std::vector<std::uint32_t> reflex;
    for (std::uint32_t i = 0; i < count; ++i)
      if (!is_convex(i)) reflex.push_back(i);
    reflex_.emplace(flat, std::move(reflex));
    for (std::uint32_t i = 0; i < count; ++i) open(i);
  }

  std::uint32_t next(std::uint32_t i) const { return corners_[i].next; }
  std::uint32_t previous(std::uint32_t i) const { return corners_[i].previous; }

  // That with the smallest circle, so that the triangles are nearly Delaunay's: bands get some from
  // side to side, chains no fans. None where no corner is an ear.
  std::optional<std::uint32_t> best_ear() {
    while (!open_.empty()) {
      const Candidate candidate = open_.top();
      open_.pop();
      const std::uint32_t i = candidate.corner;
      const bool is_old = previous(i) != candidate.previous || next(i) != candidate.next;
      const bool is_cut = next(previous(i)) != i;
      if (is_old || is_cut || corners_[i].watched != kNoCorner) continue;
      if (is_ear(i)) return i;
    }
    return std::nullopt;
  }

  void cut(std::uint32_t i) {
    const std::uint32_t before = previous(i), after = next(i);
    corners_[before].next = after;
    corners_[after].previous = before;
    unwatch(i);
    stop_blocking(i);
    // A cut can only open the corners beside it.
    for (const std::uint32_t beside : {before, after}) {
      if (is_convex(beside)) stop_blocking(beside);
      unwatch(beside);
      open(beside);
    }
  }

 private:
  struct Corner {
    std::uint32_t next, previous;
    // Corners that this one keeps from being ears, a list of its own; and where that list goes on.
    std::uint32_t first_watcher = kNoCorner, watcher_after = kNoCorner, watcher_before = kNoCorner;
    std::uint32_t watched = kNoCorner;  // the corner that keeps this one from being an ear
  };

  // A corner that may be an ear, between these two.
  struct Candidate {
    std::uint32_t radius, diagonal;  // see rounded()
    std::uint32_t corner, previous, next;

    // Of those with circles alike, the one that cuts off less: a round polygon falls into even
    // pieces.
    bool operator>(const Candidate& other) const {
      return std::tie(radius, diagonal, corner) >
             std::tie(other.radius, other.diagonal, other.corner);
    }
  };

  void open(std::uint32_t i) {
    const glm::dvec2 &own = flat_[i], &before = flat_[previous(i)], &after = flat_[next(i)];
    const double diagonal = glm::distance(before, after);
    const double radius = glm::distance(before, own) * glm::distance(own, after) * diagonal /
                          (2 * turn(before, own, after));
    open_.push({rounded(radius, 2), rounded(diagonal, 12), i, previous(i), next(i)});
  }

  bool is_convex(std::uint32_t i) const {
    return turn(flat_[previous(i)], flat_[i], flat_[next(i)]) > 0;
  }

  // An ear is a convex corner whose triangle holds no other corner; only reflex ones can be in it.
  // One that is none is asked again when the corners beside it change, or the one in it.
  bool is_ear(std::uint32_t i) {
    if (!is_convex(i)) return false;
    const std::uint32_t blocker = reflex_->inside({flat_[previous(i)], flat_[i], flat_[next(i)]});
    if (blocker == kNoCorner) return true;
    std::uint32_t& first = corners_[blocker].first_watcher;
    corners_[i].watched = blocker;
    corners_[i].watcher_before = kNoCorner;
    corners_[i].watcher_after = first;
    if (first != kNoCorner) corners_[first].watcher_before = i;
    first = i;
    return false;
  }

  void unwatch(std::uint32_t i) {
    Corner& own = corners_[i];
    if (own.watched == kNoCorner) return;
    std::uint32_t& to_own = own.watcher_before == kNoCorner
                                ? corners_[own.watched].first_watcher
                                : corners_[own.watcher_before].watcher_after;
    to_own = own.watcher_after;
    if (own.watcher_after != kNoCorner)
      corners_[own.watcher_after].watcher_before = own.watcher_before;
    own.watched = kNoCorner;
  }

  void stop_blocking(std::uint32_t i) {
    reflex_->erase(i);
    for (std::uint32_t w = corners_[i].first_watcher; w != kNoCorner;
         w = corners_[w].watcher_after) {
      open(w);
      corners_[w].watched = kNoCorner;
    }
    corners_[i].first_watcher = kNoCorner;
  }

  std::span<const glm::dvec2> flat_;
  std::vector<Corner> corners_;
  std::optional<ReflexCorners> reflex_;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> open_;
};

}  // namespace

std::vector<std::array<std::uint32_t, 3>> clip_ears(std::span<const glm::dvec2> polygon) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  triangles.reserve(polygon.size());
  Ears ears(polygon);
  std::uint32_t corner = 0;
  for (std::size_t left = polygon.size(); left > 2; --left) {
    // Where no corner is an ear the polygon crosses itself or has no area: cut it anyhow.
    corner = ears.best_ear().value_or(corner);
    triangles.push_back({ears.previous(corner), corner, ears.next(corner)});
    ears.cut(corner);
    corner = ears.next(corner);
  }
  return triangles;
}

namespace {

// Based on: Sutherland, Sproull and Schumacker, "A characterization of ten hidden-surface
// algorithms", 1974 (Newell's normal).

constexpr std::array<std::uint8_t, 6> kSplitFrom0{0, 1, 2, 0, 2, 3};
constexpr std::array<std::uint8_t, 6> kSplitFrom1{0, 1, 3, 1, 2, 3};

// The polygon seen along its Newell normal, counter-clockwise.
std::vector<glm::dvec2> flatten(std::span<const std::int32_t> corners,
                                std::span<const glm::dvec3> positions) {
  // About the first corner, so that a polygon far from the origin keeps its digits.
  const glm::dvec3 origin = positions[corners[0]];
  glm::dvec3 normal(0.0);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::size_t next = i + 1 < corners.size() ? i + 1 : 0;
    normal += glm::cross(positions[corners[i]] - origin, positions[corners[next]] - origin);
  }
  // Dropping the normal's largest component keeps the order of turns, which is all that counts.
  const glm::dvec3 size = glm::abs(normal);
  const int drop = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  int u = (drop + 1) % 3, v = (drop + 2) % 3;
  if (normal[drop] < 0) std::swap(u, v);
  std::vector<glm::dvec2> flat(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 from_origin = positions[corners[i]] - origin;
    flat[i] = {from_origin[u], from_origin[v]};
  }
  return flat;
}

}  // namespace

std::array<std::uint8_t, 6> split_quad(const glm::dvec3& corner0, const glm::dvec3& corner1,
                                       const glm::dvec3& corner2, const glm::dvec3& corner3) {
  return is_cut_from_1(corner0, corner1, corner2, corner3) ? kSplitFrom1 : kSplitFrom0;
}

void triangulate(std::span<const std::int32_t> corners, std::span<const glm::dvec3> positions,
                 std::span<std::uint32_t> triangles) {
  PLANISH_ASSERT(corners.size() >= 3 && triangles.size() == 3 * (corners.size() - 2));
  if (corners.size() == 3) {
    std::copy(corners.begin(), corners.end(), triangles.begin());
    return;
  }
  if (corners.size() == 4) {
    const auto split = split_quad(positions[corners[0]], positions[corners[1]],
                                  positions[corners[2]], positions[corners[3]]);
    std::transform(split.begin(), split.end(), triangles.begin(), [&](std::uint8_t corner) {
      return static_cast<std::uint32_t>(corners[corner]);
    });
    return;
  }
  const std::vector<glm::dvec2> flat = flatten(corners, positions);
  std::uint32_t* written = triangles.data();
  for (const std::array<std::uint32_t, 3>& triangle : clip_ears(flat))
    for (const std::uint32_t place : triangle)
      *written++ = static_cast<std::uint32_t>(corners[place]);
}

}  // namespace planish
