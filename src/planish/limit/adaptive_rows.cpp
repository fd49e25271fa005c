#include "planish/limit/adaptive_rows.h"

#include <algorithm>
#include <iterator>

#include "planish/core/parallel.h"

namespace planish {
namespace {

constexpr std::size_t kListGrain = 256;

}  // namespace

SidePlaces::SidePlaces(const MeshTopology& topology, const AdaptiveCells& cells)
    : topology_(topology), cells_(cells) {
  struct Scratch {
    std::vector<std::uint16_t> own, other;
  };
  const auto joined = [&](std::int32_t corner, int side, std::int32_t other, int other_side,
                          std::vector<std::uint16_t>& result) {
    thread_local Scratch scratch;
    result.clear();
    scratch.own.clear();
    scratch.other.clear();
    if (corner >= 0) side_places(cells_.of(corner), side, scratch.own);
    if (other >= 0) side_places(cells_.of(other), other_side, scratch.other);
    std::ranges::set_union(scratch.own, scratch.other, std::back_inserter(result));
  };
  fill(leading_, [&](std::int32_t c, std::vector<std::uint16_t>& result) {
    joined(c, 0, topology_.cw(c), 3, result);
  });
  fill(spoke_, [&](std::int32_t c, std::vector<std::uint16_t>& result) {
    joined(c, 1, topology_.next(c), 2, result);
  });
  fill(lone_trailing_, [&](std::int32_t c, std::vector<std::uint16_t>& result) {
    joined(across(c) < 0 ? c : -1, 3, -1, 0, result);
  });
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

std::int32_t SidePlaces::across(std::int32_t corner) const {
  const std::int32_t other = topology_.ccw(corner);
  return other >= 0 && cells_.hidden[static_cast<std::size_t>(other)] == 0 ? other : -1;
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
    if (cells.hidden[static_cast<std::size_t>(c)] == 0) {
      own = static_cast<std::int64_t>(sides.leading(c).size() + sides.spoke(c).size()) +
            inside[static_cast<std::size_t>(c)];
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

void AdaptiveRows::rows_of(std::int32_t corner, const CornerGrid& grid,
                           std::vector<std::int32_t>& rows) const {
  const std::int32_t before = topology_.prev(corner);
  auto leading = static_cast<std::int32_t>(first_of(corner));
  auto spoke = leading + static_cast<std::int32_t>(sides_.leading(corner).size());
  auto within = spoke + static_cast<std::int32_t>(sides_.spoke(corner).size());
  auto far_spoke = static_cast<std::int32_t>(
      first_of(before) + static_cast<std::int64_t>(sides_.leading(before).size()));
  auto trailing =
      owns_trailing(corner)
          ? static_cast<std::int32_t>(first_[static_cast<std::size_t>(corner) + 1] -
                                      static_cast<std::int64_t>(sides_.trailing(corner).size()))
          : static_cast<std::int32_t>(first_of(sides_.across(corner)));
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
