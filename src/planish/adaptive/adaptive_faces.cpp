#include "planish/adaptive/adaptive_faces.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <numeric>
#include <span>

#include "planish/core/guards.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

std::uint32_t key_of(std::int32_t first, std::int32_t second) {
  return static_cast<std::uint32_t>(first) << 16 | static_cast<std::uint32_t>(second);
}

void sort_unique(std::vector<std::uint16_t>& values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

void side_places(std::span<const AdaptiveCell> cells, int side,
                 std::vector<std::uint16_t>& places) {
  places.clear();
  for (const AdaptiveCell& cell : cells) {
    const bool touches = side == 0   ? cell.v == 0
                         : side == 1 ? cell.end_u == kCellSide
                         : side == 2 ? cell.end_v == kCellSide
                                     : cell.u == 0;
    if (!touches) continue;
    const bool along_u = side % 2 == 0;
    const std::uint16_t first = along_u ? cell.u : cell.v;
    const std::int32_t last = along_u ? cell.end_u : cell.end_v;
    if (first > 0) places.push_back(first);
    if (last < kCellSide) places.push_back(static_cast<std::uint16_t>(last));
  }
  sort_unique(places);
}

void CornerGrid::build(std::span<const AdaptiveCell> cells, const Sides& sides) {
  rows_.clear();
  for (const AdaptiveCell& cell : cells) {
    for (const std::uint16_t v : {cell.v, cell.end_v}) {
      rows_.push_back(key_of(v, cell.u));
      rows_.push_back(key_of(v, cell.end_u));
    }
  }
  for (const std::uint16_t t : sides[0]) rows_.push_back(key_of(0, t));
  for (const std::uint16_t t : sides[1]) rows_.push_back(key_of(t, kCellSide));
  for (const std::uint16_t t : sides[2]) rows_.push_back(key_of(kCellSide, t));
  for (const std::uint16_t t : sides[3]) rows_.push_back(key_of(t, 0));
  std::ranges::sort(rows_);
  rows_.erase(std::unique(rows_.begin(), rows_.end()), rows_.end());
  places_.clear();
  for (const std::uint32_t key : rows_)
    places_.push_back(
        {static_cast<std::uint16_t>(key & 0xffff), static_cast<std::uint16_t>(key >> 16)});
  column_places_.resize(places_.size());
  std::iota(column_places_.begin(), column_places_.end(), 0);
  std::ranges::sort(column_places_, {}, [&](std::int32_t i) {
    const CellPlace& place = places_[i];
    return key_of(place.u, place.v);
  });
  columns_.clear();
  for (const std::int32_t i : column_places_) {
    const CellPlace& place = places_[i];
    columns_.push_back(key_of(place.u, place.v));
  }
}

std::span<const std::int32_t> CornerGrid::polygon(const AdaptiveCell& cell) {
  polygon_.clear();
  const auto at = [](const std::vector<std::uint32_t>& keys, std::uint32_t key) {
    return static_cast<std::int32_t>(std::ranges::lower_bound(keys, key) - keys.begin());
  };
  const std::int32_t u0 = cell.u, u1 = cell.end_u, v0 = cell.v, v1 = cell.end_v;
  // Each side without its last place.
  for (std::int32_t i = at(rows_, key_of(v0, u0)); i < at(rows_, key_of(v0, u1)); ++i)
    polygon_.push_back(i);
  const auto column_place = [&](std::int32_t i) { return column_places_[i]; };
  for (std::int32_t i = at(columns_, key_of(u1, v0)); i < at(columns_, key_of(u1, v1)); ++i)
    polygon_.push_back(column_place(i));
  for (std::int32_t i = at(rows_, key_of(v1, u1)); i > at(rows_, key_of(v1, u0)); --i)
    polygon_.push_back(i);
  for (std::int32_t i = at(columns_, key_of(u0, v1)); i > at(columns_, key_of(u0, v0)); --i)
    polygon_.push_back(column_place(i));
  return polygon_;
}

namespace {

std::int64_t double_area(const CellPlace& a, const CellPlace& b, const CellPlace& c) {
  const std::int64_t bu = std::int64_t{b.u} - a.u, bv = std::int64_t{b.v} - a.v;
  const std::int64_t cu = std::int64_t{c.u} - a.u, cv = std::int64_t{c.v} - a.v;
  return bu * cv - bv * cu;
}

// Area by the sum of squared sides, 1 for equilateral triangles.
double shape_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 ab = b - a, bc = c - b, ca = a - c;
  const double squares = glm::dot(ab, ab) + glm::dot(bc, bc) + glm::dot(ca, ca);
  return squares > 0 ? 2 * std::sqrt(3.0) * glm::length(glm::cross(ab, ca)) / squares : 0;
}

}  // namespace

CellTriangles::Ear CellTriangles::ear_at(std::size_t i) const {
  const std::size_t n = ring_.size();
  const auto a = static_cast<std::size_t>(ring_[(i + n - 1) % n]);
  const auto b = static_cast<std::size_t>(ring_[i]);
  const auto c = static_cast<std::size_t>(ring_[(i + 1) % n]);
  return {double_area(places_[a], places_[b], places_[c]),
          shape_of(positions_[a], positions_[b], positions_[c])};
}

std::span<const std::array<std::int32_t, 3>> CellTriangles::cut(
    std::span<const CellPlace> places, std::span<const glm::dvec3> positions) {
  places_ = places;
  positions_ = positions;
  triangles_.clear();
  ring_.clear();
  std::int64_t rest = 0;  // twice the area that is left
  for (std::size_t i = 0; i < places.size(); ++i) {
    ring_.push_back(static_cast<std::int32_t>(i));
    if (i >= 2) rest += double_area(places[0], places[i - 1], places[i]);
  }
  ears_.resize(ring_.size());
  for (std::size_t i = 0; i < ring_.size(); ++i) ears_[i] = ear_at(i);
  while (ring_.size() > 2) {
    const std::size_t n = ring_.size();
    std::size_t best = n;
    for (std::size_t i = 0; i < n; ++i) {
      // What is left must not be a line.
      if (ears_[i].area <= 0 || (n > 3 && ears_[i].area >= rest)) continue;
      if (best == n || ears_[i].shape > ears_[best].shape + kCutTie) best = i;
    }
    PLANISH_ASSERT(best < n);
    triangles_.push_back({ring_[(best + n - 1) % n], ring_[best], ring_[(best + 1) % n]});
    rest -= ears_[best].area;
    ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(best));
    ears_.erase(ears_.begin() + static_cast<std::ptrdiff_t>(best));
    if (ring_.size() < 3) break;
    const std::size_t m = ring_.size();
    ears_[best % m] = ear_at(best % m);
    ears_[(best + m - 1) % m] = ear_at((best + m - 1) % m);
  }
  return triangles_;
}

namespace {

constexpr std::size_t kListGrain = 256;

// Places of an edge as its other side has them: backwards.
void reflect(std::span<std::uint16_t> places) {
  for (std::uint16_t& place : places) place = static_cast<std::uint16_t>(2 * kCellSide - place);
  std::ranges::reverse(places);
}

void sort_unique_places(std::vector<std::uint16_t>& places) {
  std::ranges::sort(places);
  places.erase(std::unique(places.begin(), places.end()), places.end());
}

// Parts longer than so much are cut evenly.
void fill_gaps(std::int32_t longest, std::vector<std::uint16_t>& places) {
  std::vector<std::uint16_t> more;
  std::int32_t from = 0;
  for (std::size_t i = 0; i <= places.size(); ++i) {
    const std::int32_t to = i < places.size() ? places[i] : 2 * kCellSide;
    const std::int32_t parts = (to - from + longest - 1) / longest;
    for (std::int32_t k = 1; k < parts; ++k)
      more.push_back(static_cast<std::uint16_t>(from + (to - from) * k / parts));
    from = to;
  }
  places.insert(places.end(), more.begin(), more.end());
  std::ranges::sort(places);
}

}  // namespace

SidePlaces::SidePlaces(const MeshTopology& topology, const AdaptiveCells& cells)
    : topology_(topology),
      cells_(cells),
      has_midpoint_(static_cast<std::size_t>(topology.corner_count()), 0) {
  fill(leading_, [&](std::int32_t c, std::vector<std::uint16_t>& result) {
    edge_places(c, result);
    const auto half = std::ranges::lower_bound(result, kCellSide);
    has_midpoint_[c] = half != result.end() && *half == kCellSide;
    result.erase(half, result.end());
  });
  fill(spoke_, [&](std::int32_t c, std::vector<std::uint16_t>& result) {
    thread_local std::vector<std::uint16_t> own, other;
    side_places(cells_.of(c), 1, own);
    side_places(cells_.of(topology_.next(c)), 2, other);
    result.clear();
    std::ranges::set_union(own, other, std::back_inserter(result));
  });
  fill(lone_trailing_, [&](std::int32_t c, std::vector<std::uint16_t>& result) {
    result.clear();
    if (across(c) >= 0) return;
    edge_places(topology_.prev(c), result);
    reflect(result);
    result.erase(std::ranges::lower_bound(result, kCellSide), result.end());
  });
}

// Of the grid of a corner's face along its leading edge; 0: it has none.
int SidePlaces::grid_parts(std::int32_t corner) const {
  const FaceGrid& grid = cells_.grids[topology_.face_of(corner)];
  return grid.exists() ? grid.parts_of_side(topology_.place_of(corner)) : 0;
}

// Those that cells of a corner's face have along its leading edge, the midpoint included.
void SidePlaces::add_cell_places(std::int32_t corner, std::vector<std::uint16_t>& places) const {
  thread_local std::vector<std::uint16_t> half;
  side_places(cells_.of(corner), 0, half);
  places.insert(places.end(), half.begin(), half.end());
  places.push_back(kCellSide);
  side_places(cells_.of(topology_.next(corner)), 3, half);
  for (const std::uint16_t place : half)
    places.push_back(static_cast<std::uint16_t>(2 * kCellSide - place));
}

// All along a corner's leading edge, ascending, without its ends: the same from both sides.
void SidePlaces::edge_places(std::int32_t corner, std::vector<std::uint16_t>& places) const {
  places.clear();
  const auto is_visible = [&](std::int32_t c) { return c >= 0 && cells_.hidden[c] == 0; };
  const std::int32_t other = topology_.twin(corner);
  const std::int32_t from = std::min(corner, other < 0 ? corner : other);
  const std::int32_t to = topology_.twin(from);
  int finest = 0;
  for (const std::int32_t side : {from, to}) {
    if (!is_visible(side)) continue;
    const int parts = grid_parts(side);
    finest = std::max(finest, parts);
    if (parts > 0) continue;
    const auto before = static_cast<std::ptrdiff_t>(places.size());
    add_cell_places(side, places);
    if (side == to) reflect(std::span(places).subspan(static_cast<std::size_t>(before)));
  }
  if (places.empty()) {
    for (int i = 1; i < finest; ++i) places.push_back(even_place(i, finest));
  } else {
    sort_unique_places(places);
    if (finest > 0) fill_gaps(2 * kCellSide / finest, places);
  }
  if (corner != from) reflect(places);
}

// Blocks of corners, joined in their order.
template <class Make>
void SidePlaces::fill(Lists& lists, const Make& make) const {
  const auto count = static_cast<std::size_t>(topology_.corner_count());
  const std::size_t blocks = (count + kListGrain - 1) / kListGrain;
  std::vector<std::vector<std::uint16_t>> of_block(blocks);
  std::vector<std::int32_t> sizes(count, 0);
  parallel_for(blocks, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint16_t> places;
    for (std::size_t b = begin; b < end; ++b) {
      for (std::size_t c = b * kListGrain; c < std::min(count, (b + 1) * kListGrain); ++c) {
        make(static_cast<std::int32_t>(c), places);
        sizes[c] = static_cast<std::int32_t>(places.size());
        of_block[b].insert(of_block[b].end(), places.begin(), places.end());
      }
    }
  });
  for (const std::int32_t size : sizes) lists.first.push_back(lists.first.back() + size);
  lists.places.resize(static_cast<std::size_t>(lists.first.back()));
  auto to = lists.places.begin();
  for (const auto& places : of_block) to = std::copy(places.begin(), places.end(), to);
}

RawVector<AdaptivePlace> level_one_places(const MeshTopology& topology, const AdaptiveCells& cells,
                                          const PatchNumbering& level_one, std::int64_t count) {
  RawVector<AdaptivePlace> places(static_cast<std::size_t>(count), AdaptivePlace{});
  const auto side = static_cast<std::uint16_t>(kCellSide);
  // Several corners name a row: one after another.
  for (const bool is_hidden : {true, false}) {
    for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
      if ((cells.hidden[c] != 0) != is_hidden) continue;
      // A vertex without any visible face has no row; its texture coordinates have one.
      if (const std::int32_t row = level_one.vertex_row(c); row >= 0) places[row] = {c, 0, 0};
      if (is_hidden) continue;
      places[level_one.edge_row(c)] = {c, side, 0};
      places[level_one.face_row(topology.face_of(c))] = {c, side, side};
    }
  }
  return places;
}

std::int32_t SidePlaces::across(std::int32_t corner) const {
  const std::int32_t other = topology_.ccw(corner);
  return other >= 0 && cells_.hidden[other] == 0 ? other : -1;
}

std::span<const std::uint16_t> SidePlaces::trailing(std::int32_t corner) const {
  const std::int32_t other = across(corner);
  return other < 0 ? lone_trailing_.of(corner) : leading(other);
}

AdaptiveRows::AdaptiveRows(const MeshTopology& topology, const AdaptiveCells& cells,
                           const SidePlaces& sides, const PatchNumbering& level_one,
                           std::span<const std::int32_t> inside)
    : topology_(topology), sides_(sides), level_one_(level_one) {
  first_.push_back(level_one.row_count());
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
    std::int64_t own = 0;
    if (cells.hidden[c] == 0) {
      own = static_cast<std::int64_t>(sides.leading(c).size() + sides.spoke(c).size()) + inside[c];
      if (owns_trailing(c)) own += static_cast<std::int64_t>(sides.trailing(c).size());
    }
    first_.push_back(first_.back() + own);
  }
}

bool AdaptiveRows::owns_trailing(std::int32_t corner) const {
  if (sides_.across(corner) < 0) return true;
  const std::int32_t before = topology_.prev(corner);
  return level_one_.edge_row(before) != level_one_.edge_row(topology_.twin(before));
}

std::int64_t AdaptiveRows::first_trailing(std::int32_t corner) const {
  return owns_trailing(corner)
             ? first_[corner + 1] - static_cast<std::int64_t>(sides_.trailing(corner).size())
             : first_of(sides_.across(corner));
}

void AdaptiveRows::along_edge(std::int32_t corner, std::vector<std::uint16_t>& places,
                              std::vector<std::int32_t>& rows) const {
  places.push_back(0);
  rows.push_back(level_one_.vertex_row(corner));
  auto row = static_cast<std::int32_t>(first_of(corner));
  for (const std::uint16_t place : sides_.leading(corner)) {
    places.push_back(place);
    rows.push_back(row++);
  }
  if (sides_.has_midpoint(corner)) {
    places.push_back(kCellSide);
    rows.push_back(level_one_.edge_row(corner));
  }
  const std::int32_t next = topology_.next(corner);
  const std::span<const std::uint16_t> rest = sides_.trailing(next);
  row = static_cast<std::int32_t>(first_trailing(next)) + static_cast<std::int32_t>(rest.size());
  for (std::size_t i = rest.size(); i-- > 0;) {
    places.push_back(static_cast<std::uint16_t>(2 * kCellSide - rest[i]));
    rows.push_back(--row);
  }
}

void AdaptiveRows::rows_of(std::int32_t corner, const CornerGrid& grid,
                           std::vector<std::int32_t>& rows) const {
  const std::int32_t before = topology_.prev(corner);
  auto leading = static_cast<std::int32_t>(first_of(corner));
  auto spoke = leading + static_cast<std::int32_t>(sides_.leading(corner).size());
  auto within = static_cast<std::int32_t>(first_within(corner));
  auto far_spoke = static_cast<std::int32_t>(
      first_of(before) + static_cast<std::int64_t>(sides_.leading(before).size()));
  auto trailing = static_cast<std::int32_t>(first_trailing(corner));
  rows.clear();
  for (const CellPlace& place : grid.places()) {
    const bool at_v = place.u == 0, at_e = place.u == kCellSide;
    if (place.v == 0) {
      rows.push_back(at_v   ? level_one_.vertex_row(corner)
                     : at_e ? level_one_.edge_row(corner)
                            : leading++);
    } else if (place.v == kCellSide) {
      rows.push_back(at_v   ? level_one_.edge_row(before)
                     : at_e ? level_one_.face_row(topology_.face_of(corner))
                            : far_spoke++);
    } else {
      rows.push_back(at_v ? trailing++ : at_e ? spoke++ : within++);
    }
  }
}

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

const FaceGrid* AdaptiveFaces::grid_at(std::int32_t corner) const {
  const FaceGrid& grid = grid_of(corner);
  return grid.exists() && topology_.place_of(corner) == 0 ? &grid : nullptr;
}

AdaptiveFaces::Counts AdaptiveFaces::counts(std::int32_t corner, CornerGrid& grid) const {
  Counts counts;
  if (const FaceGrid* const whole = grid_at(corner)) {
    std::size_t around = 0;
    for (std::int32_t c = corner; c < corner + 4; ++c)
      around += 1 + sides_.leading(c).size() + (sides_.has_midpoint(c) ? 1 : 0) +
                sides_.trailing(c).size();
    counts.inside = whole->inside();
    counts.triangles = static_cast<std::int64_t>(around) - 2 + 2 * std::int64_t{whole->inside()};
  }
  if (grid_of(corner).exists()) return counts;
  for (const CellPlace& place : grid.places()) {
    if (place.u > 0 && place.u < kCellSide && place.v > 0 && place.v < kCellSide) ++counts.inside;
  }
  for (const AdaptiveCell& cell : cells_.of(corner))
    counts.triangles += static_cast<std::int64_t>(grid.polygon(cell).size()) - 2;
  return counts;
}

// Of the corner's places or, in the order of GridTriangles, of all vertices of a face's grid.
void AdaptiveFaces::take_rows(std::int32_t corner, const CornerGrid& grid, const AdaptiveRows& rows,
                              Scratch& scratch) const {
  const FaceGrid* const whole = grid_at(corner);
  if (whole == nullptr) {
    rows.rows_of(corner, grid, scratch.rows);
    return;
  }
  scratch.rows.clear();
  for (std::int32_t i = 0; i < 4; ++i) {
    std::vector<std::uint16_t>& side = scratch.sides[i];
    side.clear();
    rows.along_edge(corner + i, side, scratch.rows);
  }
  const auto within = static_cast<std::int32_t>(rows.first_within(corner));
  for (std::int32_t i = 0; i < whole->inside(); ++i) scratch.rows.push_back(within + i);
}

// By places of the corner.
void AdaptiveFaces::cut_cells(std::int32_t corner, CornerGrid& grid, Scratch& scratch) const {
  const auto cut = [&](std::span<const std::int32_t> polygon) {
    scratch.places.clear();
    scratch.around.clear();
    for (const std::int32_t i : polygon) {
      const auto place = static_cast<std::size_t>(i);
      scratch.places.push_back(grid.places()[place]);
      scratch.around.push_back(scratch.points[place]);
    }
    for (const auto& triangle : scratch.cells.cut(scratch.places, scratch.around)) {
      for (const std::int32_t k : triangle) scratch.vertices.push_back(polygon[k]);
    }
  };
  // Two corners that share both edges at their vertex must not join the same places of these.
  const bool is_pair = topology_.cw(corner) >= 0 && topology_.cw(corner) == topology_.ccw(corner);
  for (const AdaptiveCell& cell : cells_.of(corner)) {
    const std::span<const std::int32_t> polygon = grid.polygon(cell);
    if (!is_pair || cell.u > 0 || cell.v > 0) {
      cut(polygon);
      continue;
    }
    const auto far = std::ranges::find_if(polygon, [&](std::int32_t i) {
      const CellPlace& place = grid.places()[i];
      return place.u == cell.end_u && place.v == cell.end_v;
    });
    scratch.half.assign(polygon.begin(), far + 1);
    cut(scratch.half);
    scratch.half.assign(far, polygon.end());
    scratch.half.push_back(polygon.front());
    cut(scratch.half);
  }
}

void AdaptiveFaces::cut_grid(std::int32_t corner, Scratch& scratch) const {
  const auto& [a, b, c, d] = scratch.sides;
  for (const auto& triangle : scratch.grids.cut(grid_of(corner), {a, b, c, d}, scratch.points))
    scratch.vertices.insert(scratch.vertices.end(), triangle.begin(), triangle.end());
}

void AdaptiveFaces::cut(std::int32_t corner, CornerGrid& grid, const AdaptiveRows& rows,
                        const RawVector<glm::dvec3>& positions, Scratch& scratch,
                        std::span<std::int32_t> result) const {
  scratch.vertices.clear();
  if (result.empty()) return;
  take_rows(corner, grid, rows, scratch);
  scratch.points.clear();
  for (const std::int32_t row : scratch.rows) scratch.points.push_back(positions[row]);
  if (grid_at(corner) != nullptr)
    cut_grid(corner, scratch);
  else
    cut_cells(corner, grid, scratch);
  PLANISH_ASSERT(scratch.vertices.size() == result.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = scratch.rows[scratch.vertices[i]];
}

void AdaptiveFaces::name(std::int32_t corner, const CornerGrid& grid, const AdaptiveRows& rows,
                         Scratch& scratch, std::span<std::int32_t> result) const {
  if (result.empty()) return;
  take_rows(corner, grid, rows, scratch);
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = scratch.rows[scratch.vertices[i]];
}

}  // namespace planish
