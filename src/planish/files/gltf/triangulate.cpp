// Based on: Meisters, "Polygons have ears", 1975; Sutherland, Sproull and Schumacker, "A
// characterization of ten hidden-surface algorithms", 1974 (Newell's normal).
#include "planish/files/gltf/triangulate.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <vector>

#include "planish/core/assert.h"
#include "planish/surface/quad_cut.h"

namespace planish {
namespace {

constexpr std::array<std::uint8_t, 6> kSplitFrom0{0, 1, 2, 0, 2, 3};
constexpr std::array<std::uint8_t, 6> kSplitFrom1{0, 1, 3, 1, 2, 3};

// Positive where b turns left seen from a towards c.
double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

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

// What is left of a polygon while ears are cut off.
class Ears {
 public:
  explicit Ears(std::span<const glm::dvec2> flat) : flat_(flat) {
    const auto count = static_cast<std::uint32_t>(flat.size());
    next_.resize(count);
    previous_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      next_[i] = i + 1 < count ? i + 1 : 0;
      previous_[i] = i > 0 ? i - 1 : count - 1;
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!is_convex(i)) reflex_.push_back(i);
    }
  }

  std::uint32_t next(std::uint32_t i) const { return next_[i]; }
  std::uint32_t previous(std::uint32_t i) const { return previous_[i]; }

  // An ear is a convex corner whose triangle holds no other corner; only reflex ones can be in it.
  bool is_ear(std::uint32_t i) const {
    return is_convex(i) && std::none_of(reflex_.begin(), reflex_.end(),
                                        [&](std::uint32_t other) { return blocks(other, i); });
  }

  void cut(std::uint32_t i) {
    next_[previous_[i]] = next_[i];
    previous_[next_[i]] = previous_[i];
    // A cut can only open the corners beside it.
    const std::uint32_t before = previous_[i], after = next_[i];
    std::erase_if(reflex_, [&](std::uint32_t other) {
      return other == i || ((other == before || other == after) && is_convex(other));
    });
  }

 private:
  bool is_convex(std::uint32_t i) const {
    return turn(flat_[previous_[i]], flat_[i], flat_[next_[i]]) > 0;
  }

  bool blocks(std::uint32_t other, std::uint32_t ear) const {
    const glm::dvec2 &a = flat_[previous_[ear]], &b = flat_[ear], &c = flat_[next_[ear]];
    const glm::dvec2& p = flat_[other];
    // Corners at the same place are the seam of a polygon that touches itself: no obstacle.
    if (p == a || p == b || p == c) return false;
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
  }

  std::span<const glm::dvec2> flat_;
  std::vector<std::uint32_t> next_, previous_, reflex_;
};

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
  Ears ears(flat);
  std::uint32_t corner = 1;
  std::size_t refused = 0, written = 0;
  for (std::size_t left = corners.size(); left > 2;) {
    // Where no corner is an ear the polygon crosses itself or has no area: cut it anyhow.
    if (left > 3 && refused < left && !ears.is_ear(corner)) {
      corner = ears.next(corner);
      ++refused;
      continue;
    }
    triangles[written++] = static_cast<std::uint32_t>(corners[ears.previous(corner)]);
    triangles[written++] = static_cast<std::uint32_t>(corners[corner]);
    triangles[written++] = static_cast<std::uint32_t>(corners[ears.next(corner)]);
    ears.cut(corner);
    // Every second corner first: a round polygon falls into even pieces, not into a fan.
    corner = ears.next(ears.next(corner));
    --left;
    refused = 0;
  }
}

}  // namespace planish
