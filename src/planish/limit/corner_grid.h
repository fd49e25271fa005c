#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "planish/limit/adaptive_cells.h"

namespace planish {

/// A place of a corner, of kCellSide along each side.
struct CellPlace {
  std::uint16_t u = 0, v = 0;
};

/// A corner's cells with all places where their vertices are. Used again from corner to corner.
class CornerGrid {
 public:
  /// Places on the corner's sides, of both faces beside them: along v = 0, u = 1, v = 1 and u = 0,
  /// ascending, the ends left out.
  using Sides = std::array<std::span<const std::uint16_t>, 4>;

  void build(std::span<const AdaptiveCell> cells, const Sides& sides);
  /// Ascending by v, then by u.
  [[nodiscard]] std::span<const CellPlace> places() const { return places_; }
  /// The places around a cell counter-clockwise, as indices into places(); valid until the next
  /// call.
  [[nodiscard]] std::span<const std::int32_t> polygon(const AdaptiveCell& cell);

 private:
  std::vector<CellPlace> places_;
  std::vector<std::uint32_t> rows_, columns_;  // keys of places, row by row and column by column
  std::vector<std::int32_t> column_places_;    // index into places_ of each of columns_
  std::vector<std::int32_t> polygon_;
};

/// The side places of one corner by its own cells, ascending and without the ends.
void side_places(std::span<const AdaptiveCell> cells, int side, std::vector<std::uint16_t>& places);

}  // namespace planish
