#include "planish/limit/adaptive_faces.h"

#include <algorithm>

#include "planish/core/assert.h"

namespace planish {

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
