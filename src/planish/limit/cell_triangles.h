#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/limit/corner_grid.h"

namespace planish {

/// Shapes and diagonals that differ by less, relative, are equal, and the first of them is taken.
/// Symmetric cells have many, and which is larger by rounding differs between sines of one
/// platform and the next.
inline constexpr double kCutTie = 1e-9;

/// Cuts the polygon around a rectangular cell into triangles: ears, the best shaped one in space
/// first, none without area in the cell's square. `places` and `positions` are of the polygon's
/// vertices; triangles name them by number. Keeps its room from cell to cell.
class CellTriangles {
 public:
  [[nodiscard]] std::span<const std::array<std::int32_t, 3>> cut(
      std::span<const CellPlace> places, std::span<const glm::dvec3> positions);

 private:
  struct Ear {
    std::int64_t area = 0;  // twice, in the square
    double shape = 0;       // 1: equilateral
  };
  [[nodiscard]] Ear ear_at(std::size_t i) const;

  std::span<const CellPlace> places_;
  std::span<const glm::dvec3> positions_;
  std::vector<std::int32_t> ring_;
  std::vector<Ear> ears_;
  std::vector<std::array<std::int32_t, 3>> triangles_;
};

}  // namespace planish
