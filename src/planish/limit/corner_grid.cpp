#include "planish/limit/corner_grid.h"

#include <algorithm>
#include <numeric>

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

}  // namespace planish
