#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/adaptive/adaptive_cells.h"
#include "planish/adaptive/adaptive_tessellation.h"
#include "planish/core/raw_vector.h"
#include "planish/patches/patch_plan.h"

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

/// The places on the halves of edges and on the lines from edges' midpoints to faces' centres:
/// those of the cells on both sides, so that neighbours agree. Between two grids they are even, as
/// many as the finer one has; between a grid and cells those of the cells, and more where the grid
/// is finer.
class SidePlaces {
 public:
  /// All must outlive it.
  SidePlaces(const MeshTopology& topology, const AdaptiveCells& cells);

  /// Along the half of its leading edge at a corner's vertex, from the vertex.
  [[nodiscard]] std::span<const std::uint16_t> leading(std::int32_t corner) const {
    return leading_.of(corner);
  }
  /// Whether the midpoint of a corner's leading edge is one, too: it always is beside cells.
  [[nodiscard]] bool has_midpoint(std::int32_t corner) const { return has_midpoint_[corner] != 0; }
  /// From the midpoint of a corner's leading edge to the face's centre.
  [[nodiscard]] std::span<const std::uint16_t> spoke(std::int32_t corner) const {
    return spoke_.of(corner);
  }
  /// Along the half of its trailing edge at a corner's vertex, from the vertex.
  [[nodiscard]] std::span<const std::uint16_t> trailing(std::int32_t corner) const;
  [[nodiscard]] CornerGrid::Sides sides(std::int32_t corner) const {
    return {leading(corner), spoke(corner), spoke(topology_.prev(corner)), trailing(corner)};
  }
  /// The visible corner across the trailing edge, -1 where there is none.
  [[nodiscard]] std::int32_t across(std::int32_t corner) const;

 private:
  struct Lists {
    std::vector<std::int64_t> first{0};
    RawVector<std::uint16_t> places;

    [[nodiscard]] std::span<const std::uint16_t> of(std::int32_t corner) const {
      const auto c = static_cast<std::size_t>(corner);
      return std::span(places).subspan(static_cast<std::size_t>(first[c]),
                                       static_cast<std::size_t>(first[c + 1] - first[c]));
    }
  };
  template <class Make>
  void fill(Lists& lists, const Make& make) const;
  [[nodiscard]] int grid_parts(std::int32_t corner) const;
  void add_cell_places(std::int32_t corner, std::vector<std::uint16_t>& places) const;
  void edge_places(std::int32_t corner, std::vector<std::uint16_t>& places) const;

  const MeshTopology& topology_;
  const AdaptiveCells& cells_;
  Lists leading_, spoke_, lone_trailing_;  // the last where nothing is across
  std::vector<std::uint8_t> has_midpoint_;
};

/// Where the rows of level 1 lie, the first of `count`; the others are left for the caller.
/// Texture coordinates of hidden faces alone lie on these.
[[nodiscard]] RawVector<AdaptivePlace> level_one_places(const MeshTopology& topology,
                                                        const AdaptiveCells& cells,
                                                        const PatchNumbering& level_one,
                                                        std::int64_t count);

/// Place i of so many even parts of a whole edge, of 0 to 2 kCellSide.
[[nodiscard]] constexpr std::uint16_t even_place(std::int32_t i, std::int32_t parts) {
  return static_cast<std::uint16_t>((2 * kCellSide * i + parts / 2) / parts);
}

/// Rows (vertices) of an adaptive tessellation: those of level 1 first, then those that each corner
/// owns: on its half of the leading edge, on its line to the centre, within, and on the half of its
/// trailing edge where that is cut or a border. Of positions, or of texture coordinates.
class AdaptiveRows {
 public:
  /// All must outlive it. `inside`: one a corner, its places within.
  AdaptiveRows(const MeshTopology& topology, const AdaptiveCells& cells, const SidePlaces& sides,
               const PatchNumbering& level_one, std::span<const std::int32_t> inside);

  [[nodiscard]] std::int64_t count() const { return first_.back(); }
  /// The first of the rows that a corner owns.
  [[nodiscard]] std::int64_t first_of(std::int32_t corner) const { return first_[corner]; }
  /// Whether a corner has rows of its own along its trailing edge.
  [[nodiscard]] bool owns_trailing(std::int32_t corner) const;
  /// The rows of a grid's places, which are those of the corner's cells and sides.
  void rows_of(std::int32_t corner, const CornerGrid& grid, std::vector<std::int32_t>& rows) const;
  /// Appends the places along a corner's leading edge, of 0 to 2 kCellSide, and their rows: from
  /// its vertex on, without the edge's other end.
  void along_edge(std::int32_t corner, std::vector<std::uint16_t>& places,
                  std::vector<std::int32_t>& rows) const;
  /// The first of the rows within a corner or, of its first corner, a face's grid.
  [[nodiscard]] std::int64_t first_within(std::int32_t corner) const {
    return first_of(corner) +
           static_cast<std::int64_t>(sides_.leading(corner).size() + sides_.spoke(corner).size());
  }

 private:
  [[nodiscard]] std::int64_t first_trailing(std::int32_t corner) const;

  const MeshTopology& topology_;
  const SidePlaces& sides_;
  const PatchNumbering& level_one_;
  std::vector<std::int64_t> first_;  // corner_count + 1
};

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
