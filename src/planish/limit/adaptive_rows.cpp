#include "planish/limit/adaptive_rows.h"

#include <algorithm>
#include <iterator>
#include <span>

#include "planish/core/parallel.h"

namespace planish {
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

}  // namespace planish
