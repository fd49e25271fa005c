#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/limit/cell_triangles.h"
#include "planish/limit/corner_grid.h"
#include "planish/limit/face_grid.h"

namespace planish {

/// Triangles of a face's grid whose sides may have more places than it. None is longer along a side
/// than a part of the grid, nor crosses a line within it. Keeps its room from face to face.
class GridTriangles {
 public:
  /// `sides`: places along each side counter-clockwise, of 0 to 2 kCellSide, the first one
  /// included. Vertices are numbered in that order, all around; those within follow, row by row.
  /// `positions` has all of them.
  [[nodiscard]] std::span<const std::array<std::int32_t, 3>> cut(
      const FaceGrid& grid, const std::array<std::span<const std::uint16_t>, 4>& sides,
      std::span<const glm::dvec3> positions);

 private:
  // Vertices along a line, with their places.
  struct Line {
    std::vector<std::int32_t> vertices;
    std::vector<std::int32_t> places;
  };
  void take_sides(const std::array<std::span<const std::uint16_t>, 4>& sides);
  [[nodiscard]] std::int32_t within(std::int32_t i, std::int32_t j) const;
  void add(std::int32_t a, std::int32_t b, std::int32_t c) { triangles_.push_back({a, b, c}); }
  void cut_within();
  void cut_ring(int side);
  void cut_strip();
  void cut_single(const std::array<std::span<const std::uint16_t>, 4>& sides);

  FaceGrid grid_;
  std::array<Line, 4> sides_;  // both ends included
  std::int32_t around_ = 0;
  std::span<const glm::dvec3> positions_;
  std::vector<CellPlace> places_;
  CellTriangles ears_;
  std::vector<std::array<std::int32_t, 3>> triangles_;
};

}  // namespace planish
