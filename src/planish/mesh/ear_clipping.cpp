// Based on: Meisters, "Polygons have ears", 1975.
#include "planish/mesh/ear_clipping.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

#include "planish/mesh/plane.h"
#include "planish/mesh/reflex_corners.h"

namespace planish {
namespace {

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

}  // namespace planish
