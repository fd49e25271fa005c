#pragma once

#include <algorithm>
#include <array>
#include <glm/vec3.hpp>
#include <span>

namespace planish {

/// Nine Bezier points of a piece of a patch, (i, j) at i + 3 j, i along u.
using BezierNet = std::array<glm::dvec3, 9>;

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

/// The same of a curve with three Bezier points and of the chord between any two of its places.
[[nodiscard]] double curve_bound(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

/// Of a piece that is no polynomial but lies in the hull of these points, as its places do. The
/// turn is left out.
[[nodiscard]] CellBound hull_bound(std::span<const glm::dvec3> points, const glm::dvec3& normal);

/// Largest angle between any two of these directions, from above: twice that from their mean; pi
/// where one of them has no length or they are all around.
[[nodiscard]] double spread_of(std::span<const glm::dvec3> directions);

/// Products of the derivatives' control vectors, in whose cone the normals lie.
void add_normals(const BezierNet& net, std::span<glm::dvec3, 36> normals);

}  // namespace planish
