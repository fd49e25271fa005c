#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/limit/adaptive_rows.h"
#include "planish/limit/cell_triangles.h"
#include "planish/limit/grid_triangles.h"

namespace planish {

/// The triangles of each corner's cells, and of each face's grid, which are those of its first
/// corner.
class AdaptiveFaces {
 public:
  /// All must outlive it.
  AdaptiveFaces(const MeshTopology& topology, const AdaptiveCells& cells, const SidePlaces& sides)
      : topology_(topology), cells_(cells), sides_(sides) {}

  /// Used again from corner to corner.
  struct Scratch {
    std::vector<std::int32_t> rows, half, vertices;
    std::vector<CellPlace> places;
    std::vector<glm::dvec3> points, around;
    CellTriangles cells;
    GridTriangles grids;
    std::array<std::vector<std::uint16_t>, 4> sides;
  };
  struct Counts {
    std::int32_t inside = 0;  ///< places on no side
    std::int64_t triangles = 0;
  };

  /// The grid of which a corner is the first; null: it is of none.
  [[nodiscard]] const FaceGrid* grid_at(std::int32_t corner) const;
  /// `grid`: the corner's, built from its cells and sides; so below.
  [[nodiscard]] Counts counts(std::int32_t corner, CornerGrid& grid) const;
  /// Rows of the corners of a corner's triangles, by their positions.
  void cut(std::int32_t corner, CornerGrid& grid, const AdaptiveRows& rows,
           const RawVector<glm::dvec3>& positions, Scratch& scratch,
           std::span<std::int32_t> result) const;
  /// Other rows (of texture coordinates) of the triangles that were cut last.
  void name(std::int32_t corner, const CornerGrid& grid, const AdaptiveRows& rows, Scratch& scratch,
            std::span<std::int32_t> result) const;

 private:
  [[nodiscard]] const FaceGrid& grid_of(std::int32_t corner) const {
    return cells_.grids[topology_.face_of(corner)];
  }
  void take_rows(std::int32_t corner, const CornerGrid& grid, const AdaptiveRows& rows,
                 Scratch& scratch) const;
  void cut_cells(std::int32_t corner, CornerGrid& grid, Scratch& scratch) const;
  void cut_grid(std::int32_t corner, Scratch& scratch) const;

  const MeshTopology& topology_;
  const AdaptiveCells& cells_;
  const SidePlaces& sides_;
};

}  // namespace planish
