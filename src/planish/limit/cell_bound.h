#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <span>

#include "planish/limit/bezier_net.h"

namespace planish {

/// How far triangles between places of a piece, whatever places, may be from it, and how much the
/// piece turns. Bounds: never too small.
struct CellBound {
  double distance = 0;     ///< between triangles and surface, both ways
  double turn = 0;         ///< between any two normals, radians; pi where it cannot be told
  bool u_is_worse = true;  ///< a split across u lowers the bound more
  /// Parts of `distance` by S_uu and S_vv, along the normal where there is one; of polynomials.
  double by_uu = 0, by_vv = 0;

  /// Not more than the bound in a part, about, where so many are made along u and along v.
  [[nodiscard]] double distance_in(int u, int v) const {
    return std::max(by_uu / (u * u), by_vv / (v * v));
  }
};

/// Of a polynomial piece. Linear interpolation on triangles inside a rectangle is off by at most
/// (|S_uu| + 2 |S_uv| + |S_vv|) / 8, sides being 1 in length. Across the surface counts what of it
/// is along the normal, where S_uu and S_vv of different signs do not add up, and the rest times
/// the slope.
[[nodiscard]] CellBound bound_of(const BezierNet& net);

/// A part of a region that is one polynomial, and how many times as long as it the rectangles are
/// that lie anywhere in the region.
struct BoundPiece {
  BezierNet net;
  double u = 1, v = 1;
};
/// Most pieces of a region: one of each corner of a face.
inline constexpr std::size_t kMostPieces = 4;

/// The same for rectangles that may cross from piece to piece, between which the surface and its
/// first derivatives are continuous.
[[nodiscard]] CellBound bound_of(std::span<const BoundPiece> pieces);

/// Three Bezier points of a curve.
using BezierCurve = std::array<glm::dvec3, 3>;

/// The same of curves that run on into one another and of chords as long as one of them between any
/// two of their places.
[[nodiscard]] double curve_bound(std::span<const BezierCurve> curves);

/// Of a piece that is no polynomial but lies in the hull of these points, as its places do. Its
/// normals are among directions like `normals`; its sides leave their chords by `aside`.
[[nodiscard]] CellBound hull_bound(std::span<const glm::dvec3> points,
                                   std::span<const glm::dvec3> normals, double aside);

/// Largest angle between any two of these directions, from above: twice that from their mean; pi
/// where one of them has no length or they are all around.
[[nodiscard]] double spread_of(std::span<const glm::dvec3> directions);

/// Products of the derivatives' control vectors, in whose cone the normals lie.
void add_normals(const BezierNet& net, std::span<glm::dvec3, 36> normals);

}  // namespace planish
