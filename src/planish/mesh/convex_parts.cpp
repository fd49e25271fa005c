// Based on: Hertel and Mehlhorn, "Fast triangulation of simple polygons", 1983; Lawson, "Software
// for C1 surface interpolation", 1977 (flips).
#include "planish/mesh/convex_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <utility>

#include "planish/mesh/ear_clipping.h"
#include "planish/mesh/plane.h"

namespace planish {
namespace {

using glm::dvec2;

constexpr std::uint32_t kOutside = 0xffffffff;
// A polygon of n corners is flipped so many times n at most: rounding must not flip without end.
constexpr std::size_t kFlipsPerCorner = 16;

struct HalfEdge {
  std::uint32_t from, next, previous, twin = kOutside;  // `from`: a corner of the polygon
  double angle = 0;                                     // of its face at `from`
};

// The triangles of a polygon, and what they merge to.
class Parts {
 public:
  explicit Parts(std::span<const dvec2> polygon) : polygon_(polygon) {
    using Side = std::pair<std::array<std::uint32_t, 2>, std::uint32_t>;
    std::vector<Side> sides;  // by the corners that they join
    for (const auto& triangle : clip_ears(polygon)) {
      const auto first = static_cast<std::uint32_t>(edges_.size());
      for (std::uint32_t k = 0; k < 3; ++k) {
        edges_.push_back({triangle[k], first + (k + 1) % 3, first + (k + 2) % 3});
        const auto [low, high] = std::minmax(triangle[k], triangle[(k + 1) % 3]);
        sides.push_back({{low, high}, first + k});
      }
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t s = 0; s + 1 < sides.size(); ++s) {
      if (sides[s].first != sides[s + 1].first) continue;
      edges_[sides[s].second].twin = sides[s + 1].second;
      edges_[sides[s + 1].second].twin = sides[s].second;
    }
  }

  // To a Delaunay triangulation, which ears nearly are.
  void flip_all() {
    std::vector<std::uint32_t> open;
    for (std::uint32_t h = 0; h < edges_.size(); ++h)
      if (h < edges_[h].twin && edges_[h].twin != kOutside) open.push_back(h);
    for (std::size_t left = kFlipsPerCorner * polygon_.size(); left > 0 && !open.empty();) {
      const std::uint32_t h = open.back();
      open.pop_back();
      if (!is_better_flipped(h)) continue;
      flip(h);
      --left;
      const std::uint32_t g = edges_[h].twin;
      for (const std::uint32_t side :
           {edges_[h].next, edges_[h].previous, edges_[g].next, edges_[g].previous})
        if (edges_[side].twin != kOutside) open.push_back(side);
    }
  }

  void merge(std::span<const double> allowed,
             const std::function<bool(std::size_t, std::size_t)>& may_cut) {
    std::vector<std::pair<double, std::uint32_t>> diagonals;
    for (std::uint32_t h = 0; h < edges_.size(); ++h) {
      HalfEdge& edge = edges_[h];
      const dvec2 along = place(edges_[edge.next].from) - place(edge.from);
      const dvec2 back = place(edges_[edge.previous].from) - place(edge.from);
      edge.angle = std::atan2(along.x * back.y - along.y * back.x, glm::dot(along, back));
      if (h < edge.twin && edge.twin != kOutside)
        diagonals.emplace_back(-glm::dot(along, along), h);
    }
    std::sort(diagonals.begin(), diagonals.end());
    for (const auto& [length, h] : diagonals) {
      const std::uint32_t g = edges_[h].twin;
      HalfEdge &after_h = edges_[edges_[h].next], &after_g = edges_[edges_[g].next];
      const double at_start = edges_[h].angle + after_g.angle;
      const double at_end = edges_[g].angle + after_h.angle;
      const std::uint32_t start = edges_[h].from, end = edges_[g].from;
      if ((at_start > allowed[start] || at_end > allowed[end]) && may_cut(start, end)) continue;
      link(edges_[h].previous, edges_[g].next);
      link(edges_[g].previous, edges_[h].next);
      after_g.angle = at_start;
      after_h.angle = at_end;
      edges_[h].from = edges_[g].from = kOutside;
    }
  }

  [[nodiscard]] std::vector<std::vector<std::size_t>> corners() {
    std::vector<std::vector<std::size_t>> parts;
    for (std::uint32_t h = 0; h < edges_.size(); ++h) {
      if (edges_[h].from == kOutside) continue;
      std::vector<std::size_t>& part = parts.emplace_back();
      for (std::uint32_t at = h; edges_[at].from != kOutside; at = edges_[at].next)
        part.push_back(std::exchange(edges_[at].from, kOutside));
    }
    return parts;
  }

 private:
  [[nodiscard]] const dvec2& place(std::uint32_t corner) const { return polygon_[corner]; }

  void link(std::uint32_t h, std::uint32_t next) {
    edges_[h].next = next;
    edges_[next].previous = h;
  }

  // The corner opposite of a side of a triangle.
  [[nodiscard]] const dvec2& opposite(std::uint32_t h) const {
    return place(edges_[edges_[h].previous].from);
  }

  [[nodiscard]] bool is_better_flipped(std::uint32_t h) const {
    constexpr double kRounding = 1e-12;
    const std::uint32_t g = edges_[h].twin;
    const dvec2 &a = place(edges_[h].from), &b = place(edges_[g].from);
    const dvec2 &c = opposite(h), &d = opposite(g);
    if (!(turn(d, b, c) > 0 && turn(c, a, d) > 0)) return false;
    // The angles at c and d are more than a half turn together: each is in the other's circle.
    const double sine_c = turn(c, a, b), sine_d = turn(d, b, a);
    const double cosine_c = glm::dot(a - c, b - c), cosine_d = glm::dot(b - d, a - d);
    const double size = std::abs(cosine_c * sine_d) + std::abs(sine_c * cosine_d);
    return sine_c * cosine_d + cosine_c * sine_d < -kRounding * size;
  }

  // a-b in the triangles a, b, c and b, a, d becomes d-c.
  void flip(std::uint32_t h) {
    const std::uint32_t g = edges_[h].twin;
    const std::uint32_t b_c = edges_[h].next, c_a = edges_[h].previous;
    const std::uint32_t a_d = edges_[g].next, d_b = edges_[g].previous;
    edges_[h].from = edges_[d_b].from;
    edges_[g].from = edges_[c_a].from;
    link(h, c_a);
    link(c_a, a_d);
    link(a_d, h);
    link(g, d_b);
    link(d_b, b_c);
    link(b_c, g);
  }

  std::span<const dvec2> polygon_;
  std::vector<HalfEdge> edges_;  // three a triangle; those of removed diagonals start nowhere
};

}  // namespace

std::vector<std::vector<std::size_t>> convex_parts(
    std::span<const dvec2> polygon, std::span<const double> allowed,
    const std::function<bool(std::size_t, std::size_t)>& may_cut) {
  Parts parts(polygon);
  parts.flip_all();
  parts.merge(allowed, may_cut);
  return parts.corners();
}

}  // namespace planish
