#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/limit/adaptive_cells.h"
#include "planish/limit/adaptive_place.h"
#include "planish/limit/corner_grid.h"
#include "planish/patches/patch_numbering.h"

namespace planish {

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

}  // namespace planish
