#pragma once

#include <array>
#include <cstdint>

#include "planish/limit/cell_bound.h"
#include "planish/limit/limit_surface.h"

namespace planish {

/// Even cuts of a whole face with four corners, into so many parts along its first and along its
/// second edge; none: each corner has cells of its own.
struct FaceGrid {
  std::uint8_t u = 0, v = 0;

  [[nodiscard]] bool exists() const { return u > 0; }
  [[nodiscard]] int parts_of_side(int side) const { return side % 2 == 0 ? u : v; }
  [[nodiscard]] std::int32_t inside() const { return exists() ? (u - 1) * (v - 1) : 0; }
};

/// Whether other faces share no more with a face than one edge, or one vertex: only then may
/// triangles join places of its different edges, since no others join the same.
[[nodiscard]] bool stands_alone(const MeshTopology& topology, std::int32_t face);

/// Finds grids of faces: so that triangles between their places keep a distance, whatever places
/// the sides have, as long as these are as near to each other as the grid's own.
class GridFinder {
 public:
  explicit GridFinder(const LimitSurface& surface) : corner_(surface), surface_(surface) {}

  /// What is asked of a face.
  struct Limits {
    double distance = 0;            ///< of triangles from the surface, in unit coordinates
    double turn = 0;                ///< between normals beneath a triangle, radians; 0: any
    std::array<bool, 4> borders{};  ///< sides that triangles must follow as curves
    int most = 0;                   ///< parts
  };
  /// One of the fewest parts; none where a corner is no polynomial, or within `most` parts.
  [[nodiscard]] FaceGrid find(std::int32_t face, const Limits& limits);

 private:
  // A rectangle of the face, of 0 to 2 along each side.
  struct Region {
    double u0, v0, u1, v1;
  };
  [[nodiscard]] bool take_nets(std::int32_t face);
  [[nodiscard]] bool keeps(int u, int v);
  [[nodiscard]] bool keeps_in(const Region& region, double size_u, double size_v) const;
  [[nodiscard]] bool keeps_borders(int u, int v) const;
  [[nodiscard]] bool is_slim(int u, int v) const;

  LimitSurface::Corner corner_;
  const LimitSurface& surface_;
  Limits limits_;
  std::array<BezierNet, 4> nets_;  // of the corners, as the first one sees them
  double length_u_ = 0, length_v_ = 0;
};

}  // namespace planish
