#include "planish/limit/grid_triangles.h"

#include <glm/geometric.hpp>

#include "planish/core/assert.h"
#include "planish/limit/adaptive_rows.h"

namespace planish {

void GridTriangles::take_sides(const std::array<std::span<const std::uint16_t>, 4>& sides) {
  around_ = 0;
  for (std::size_t s = 0; s < 4; ++s) {
    Line& line = sides_[s];
    line.vertices.clear();
    line.places.assign(sides[s].begin(), sides[s].end());
    for (std::size_t i = 0; i < sides[s].size(); ++i) line.vertices.push_back(around_++);
    line.places.push_back(2 * kCellSide);
  }
  for (std::size_t s = 0; s < 4; ++s)
    sides_[s].vertices.push_back(sides_[(s + 1) % 4].vertices.front());
}

// i of 1 to u - 1, j of 1 to v - 1.
std::int32_t GridTriangles::within(std::int32_t i, std::int32_t j) const {
  return around_ + (j - 1) * (grid_.u - 1) + i - 1;
}

// The parts that touch no side, along the shorter diagonal.
void GridTriangles::cut_within() {
  const auto at = [&](std::int32_t k) { return positions_[k]; };
  for (std::int32_t j = 1; j + 1 < grid_.v; ++j) {
    for (std::int32_t i = 1; i + 1 < grid_.u; ++i) {
      const std::int32_t a = within(i, j), b = within(i + 1, j);
      const std::int32_t c = within(i + 1, j + 1), d = within(i, j + 1);
      if (glm::length(at(c) - at(a)) <= (1 + kCutTie) * glm::length(at(d) - at(b))) {
        add(a, b, c);
        add(a, c, d);
      } else {
        add(b, c, d);
        add(b, d, a);
      }
    }
  }
}

// Between a side and the grid's line next to it, whichever is behind goes on: then no triangle is
// longer than a part, since neither has longer ones.
void GridTriangles::cut_ring(int side) {
  const Line& outer = sides_[side];
  const std::int32_t u = grid_.u, v = grid_.v, parts = grid_.parts_of_side(side);
  const auto inner = [&](std::int32_t k) {
    switch (side) {
      case 0:
        return within(k, 1);
      case 1:
        return within(u - 1, k);
      case 2:
        return within(u - k, v - 1);
      default:
        return within(1, v - k);
    }
  };
  std::size_t o = 0;
  std::int32_t i = 1;
  while (o + 1 < outer.places.size() || i + 1 < parts) {
    const bool outer_next = i + 1 == parts || (o + 1 < outer.places.size() &&
                                               outer.places[o + 1] <= even_place(i + 1, parts));
    if (outer_next) {
      add(outer.vertices[o], outer.vertices[o + 1], inner(i));
      ++o;
    } else {
      add(inner(i), outer.vertices[o], inner(i + 1));
      ++i;
    }
  }
}

// A grid of one part across: from side to side along it, and fans at both ends.
void GridTriangles::cut_strip() {
  const std::size_t turn = grid_.u == 1 ? 0 : 3;
  const auto side = [&](std::size_t s) -> const Line& { return sides_[(s + turn) % 4]; };
  const Line &low = side(0), &right = side(1), &high = side(2), &left = side(3);
  const std::size_t end = left.places.size() - 1;  // left runs from its upper end
  const auto left_vertex = [&](std::size_t k) { return left.vertices[end - k]; };
  const auto left_place = [&](std::size_t k) { return 2 * kCellSide - left.places[end - k]; };
  for (std::size_t i = 0; i + 1 < low.vertices.size(); ++i)
    add(low.vertices[i], low.vertices[i + 1], left_vertex(1));
  std::size_t l = 1, r = 0;
  while (l + 1 < end || r + 1 < right.places.size()) {
    if (l + 1 < end && (r + 1 == right.places.size() || left_place(l + 1) <= right.places[r + 1])) {
      add(left_vertex(l), right.vertices[r], left_vertex(l + 1));
      ++l;
    } else {
      add(left_vertex(l), right.vertices[r], right.vertices[r + 1]);
      ++r;
    }
  }
  for (std::size_t i = 0; i + 1 < high.vertices.size(); ++i)
    add(high.vertices[i], high.vertices[i + 1], left_vertex(end - 1));
}

// One part: ears of the polygon around it.
void GridTriangles::cut_single(const std::array<std::span<const std::uint16_t>, 4>& sides) {
  constexpr std::int32_t kWhole = 2 * kCellSide;
  places_.clear();
  for (std::size_t s = 0; s < 4; ++s) {
    for (const std::uint16_t t : sides[s]) {
      const auto back = static_cast<std::uint16_t>(kWhole - t);
      const auto whole = static_cast<std::uint16_t>(kWhole);
      places_.push_back(s == 0   ? CellPlace{t, 0}
                        : s == 1 ? CellPlace{whole, t}
                        : s == 2 ? CellPlace{back, whole}
                                 : CellPlace{0, back});
    }
  }
  const auto ears = ears_.cut(places_, positions_);
  triangles_.assign(ears.begin(), ears.end());
}

std::span<const std::array<std::int32_t, 3>> GridTriangles::cut(
    const FaceGrid& grid, const std::array<std::span<const std::uint16_t>, 4>& sides,
    std::span<const glm::dvec3> positions) {
  grid_ = grid;
  positions_ = positions;
  triangles_.clear();
  take_sides(sides);
  if (grid.u == 1 && grid.v == 1) {
    cut_single(sides);
  } else if (grid.u == 1 || grid.v == 1) {
    cut_strip();
  } else {
    cut_within();
    for (int side = 0; side < 4; ++side) cut_ring(side);
  }
  return triangles_;
}

}  // namespace planish
