#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/brep/spline_surface.h"

namespace planish {

/// The quads of Q_1 in rectangles whose insides are regular. Half edge 4 c + k of corner c's quad:
/// from V to E1, E1 to F, F to E2 and E2 to V.
class QuadLayout {
 public:
  /// A quad in a rectangle: its half edge `turn` runs along the rectangle's x.
  struct Cell {
    std::int32_t corner = 0, turn = 0;
  };
  struct Rectangle {
    std::int32_t width = 0, height = 0;
    std::vector<Cell> cells;  ///< (x, y) at x + width y

    [[nodiscard]] const Cell& cell(std::int32_t x, std::int32_t y) const {
      return cells[x + width * y];
    }
    /// The half edges of side 0 to 3 (below, right, above, left), counter-clockwise.
    [[nodiscard]] std::vector<std::int32_t> side(int index) const;
  };

  /// Rectangles of at most `face_size` quads a side, each of faces of one group. `groups`: one for
  /// each face of the mesh; empty: all have the same. `has_corners`: where the border of a group
  /// turns, rectangles beside it have a corner.
  QuadLayout(const SplineSurface& surface, std::int32_t face_size,
             std::span<const std::int32_t> groups = {}, bool has_corners = false);

  /// Of the polynomials on the quads.
  [[nodiscard]] std::size_t degree() const { return surface_.degree(); }
  [[nodiscard]] const std::vector<Rectangle>& rectangles() const { return rectangles_; }
  /// Vertices of Q_1: of the mesh, midpoints of its edges, centres of its faces.
  [[nodiscard]] std::int32_t origin(std::int32_t half_edge) const;
  [[nodiscard]] std::int32_t target(std::int32_t half_edge) const {
    return origin(next(half_edge));
  }
  /// Around its quad.
  static std::int32_t next(std::int32_t h) { return (h & ~3) | ((h + 1) & 3); }
  static std::int32_t previous(std::int32_t h) { return (h & ~3) | ((h + 3) & 3); }
  /// -1 at a boundary.
  [[nodiscard]] std::int32_t twin(std::int32_t half_edge) const;
  [[nodiscard]] std::int32_t rectangle_of(std::int32_t corner) const {
    return place_[corner].rectangle;
  }
  [[nodiscard]] std::int32_t vertex_count() const;
  /// Whether tracks start at a vertex of Q_1.
  [[nodiscard]] bool is_extraordinary(std::int32_t vertex) const {
    return extraordinary_[vertex] != 0;
  }
  /// Whether edges end at a vertex of Q_1.
  [[nodiscard]] bool is_end(std::int32_t vertex) const { return ends_[vertex] != 0; }
  [[nodiscard]] bool is_hidden(std::int32_t corner) const;
  [[nodiscard]] bool is_sharp(std::int32_t half_edge) const;

 private:
  struct Place {
    std::int32_t rectangle = -1, turn = 0, x = 0, y = 0;
  };

  void find_extraordinary();
  void mark(std::int32_t half_edge);
  // Tracks that start where curves turn.
  [[nodiscard]] std::vector<std::int32_t> mark_curves(std::span<const std::int32_t> groups,
                                                      bool has_corners);
  void follow(std::vector<std::int32_t> tracks);
  void seed(std::int32_t half_edge);
  // Half edges without a mark within regions that are no rectangles.
  [[nodiscard]] std::vector<std::int32_t> fill();
  void fill_all();
  [[nodiscard]] bool cut(std::int32_t face_size);
  void find_ends();

  const SplineSurface& surface_;
  const MeshTopology& topology_;
  std::vector<std::uint8_t> marked_, extraordinary_, seen_, ends_;
  std::vector<Place> place_;
  std::vector<Rectangle> rectangles_;
};

}  // namespace planish
