// Based on: Meisters, "Polygons have ears", 1975.
#include "planish/mesh/ear_clipping.h"

#include <bit>
#include <cstddef>
#include <optional>
#include <utility>

#include "planish/mesh/reflex_corners.h"

namespace planish {
namespace {

constexpr std::uint32_t kNoCorner = ReflexCorners::kNone;

// Corners of a polygon, by number, with the next one from any on: a tree of words of 64 bits.
class CornerSet {
 public:
  // All of so many.
  explicit CornerSet(std::uint32_t count) {
    for (std::size_t bits = count;; bits = levels_.back().size()) {
      levels_.emplace_back((bits + 63) / 64, ~std::uint64_t{0});
      if (bits % 64 != 0) levels_.back().back() = (std::uint64_t{1} << (bits % 64)) - 1;
      if (levels_.back().size() == 1) break;
    }
  }

  void insert(std::uint32_t i) {
    for (auto& level : levels_) {
      level[i / 64] |= std::uint64_t{1} << (i % 64);
      i /= 64;
    }
  }
  void erase(std::uint32_t i) {
    for (auto& level : levels_) {
      level[i / 64] &= ~(std::uint64_t{1} << (i % 64));
      if (level[i / 64] != 0) return;
      i /= 64;
    }
  }

  // The first one from `start` on, and then from 0 on; none where it is empty.
  [[nodiscard]] std::optional<std::uint32_t> from(std::uint32_t start) const {
    if (const auto found = not_before(start)) return found;
    return not_before(0);
  }

 private:
  [[nodiscard]] std::optional<std::uint32_t> not_before(std::uint32_t start) const {
    std::size_t at = start;
    for (std::size_t k = 0; k < levels_.size(); ++k) {
      if (at / 64 >= levels_[k].size()) return std::nullopt;
      const std::uint64_t word = levels_[k][at / 64] >> (at % 64);
      if (word == 0) {
        at = at / 64 + 1;
        continue;
      }
      at += static_cast<std::size_t>(std::countr_zero(word));
      while (k-- > 0) at = 64 * at + static_cast<std::size_t>(std::countr_zero(levels_[k][at]));
      return static_cast<std::uint32_t>(at);
    }
    return std::nullopt;
  }

  std::vector<std::vector<std::uint64_t>> levels_;  // corners first
};

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
    open_.emplace(count);
  }

  std::uint32_t next(std::uint32_t i) const { return corners_[i].next; }
  std::uint32_t previous(std::uint32_t i) const { return corners_[i].previous; }

  // The first ear from a corner on; the corner itself where there is none.
  std::uint32_t ear_from(std::uint32_t start) {
    while (const std::optional<std::uint32_t> i = open_->from(start)) {
      if (is_ear(*i)) return *i;
      open_->erase(*i);
    }
    return start;
  }

  void cut(std::uint32_t i) {
    const std::uint32_t before = previous(i), after = next(i);
    corners_[before].next = after;
    corners_[after].previous = before;
    open_->erase(i);
    unwatch(i);
    stop_blocking(i);
    // A cut can only open the corners beside it.
    for (const std::uint32_t beside : {before, after}) {
      if (is_convex(beside)) stop_blocking(beside);
      unwatch(beside);
      open_->insert(beside);
    }
  }

 private:
  struct Corner {
    std::uint32_t next, previous;
    // Corners that this one keeps from being ears, a list of its own; and where that list goes on.
    std::uint32_t first_watcher = kNoCorner, watcher_after = kNoCorner, watcher_before = kNoCorner;
    std::uint32_t watched = kNoCorner;  // the corner that keeps this one from being an ear
  };

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
      open_->insert(w);
      corners_[w].watched = kNoCorner;
    }
    corners_[i].first_watcher = kNoCorner;
  }

  std::span<const glm::dvec2> flat_;
  std::vector<Corner> corners_;
  std::optional<ReflexCorners> reflex_;
  std::optional<CornerSet> open_;  // those that may be ears
};

}  // namespace

std::vector<std::array<std::uint32_t, 3>> clip_ears(std::span<const glm::dvec2> polygon) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  triangles.reserve(polygon.size());
  Ears ears(polygon);
  std::uint32_t corner = 1;
  for (std::size_t left = polygon.size(); left > 2; --left) {
    // Where no corner is an ear the polygon crosses itself or has no area: cut it anyhow.
    if (left > 3) corner = ears.ear_from(corner);
    triangles.push_back({ears.previous(corner), corner, ears.next(corner)});
    ears.cut(corner);
    // Every second corner first: a round polygon falls into even pieces, not into a fan.
    corner = ears.next(ears.next(corner));
  }
  return triangles;
}

}  // namespace planish
