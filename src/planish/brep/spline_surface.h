#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Of splines: 2 of Doo-Sabin surfaces, 3 of Catmull-Clark's.
constexpr std::size_t kMostSplineDegree = 3;

/// Arguments of a polynomial's blossom, as many as its degree.
using BlossomArguments = std::array<double, kMostSplineDegree>;
[[nodiscard]] inline BlossomArguments same_arguments(double t) { return {t, t, t}; }

/// Those whose value is Bezier point k of the polynomial on [low, high].
[[nodiscard]] inline BlossomArguments bezier_arguments(std::size_t degree, std::size_t k,
                                                       double low, double high) {
  BlossomArguments arguments{};
  for (std::size_t a = 0; a < degree; ++a) arguments[a] = a + k < degree ? low : high;
  return arguments;
}

// Of splines by their distinct knots, ascending, of which the first and the last count degree + 1
// times, all others once.
[[nodiscard]] inline std::size_t point_count(std::size_t degree, std::span<const double> knots) {
  return knots.size() + degree - 1;
}
/// Those whose value is control point i, ascending.
[[nodiscard]] inline BlossomArguments knot_arguments(std::size_t degree,
                                                     std::span<const double> knots, std::size_t i) {
  BlossomArguments arguments{};
  for (std::size_t a = 0; a < degree; ++a) {
    const std::size_t knot = i + 1 + a;  // of those with their counts, less the first
    arguments[a] = knots[std::min(knot < degree ? 0 : knot - degree, knots.size() - 1)];
  }
  return arguments;
}

template <std::size_t kDegree, class Point>
[[nodiscard]] inline Point bezier_blossom(const Point* points, const BlossomArguments& arguments) {
  std::array<Point, kDegree + 1> left;
  for (std::size_t i = 0; i <= kDegree; ++i) left[i] = points[i];
  for (std::size_t r = 0; r < kDegree; ++r)
    for (std::size_t i = 0; i < kDegree - r; ++i)
      left[i] = (1 - arguments[r]) * left[i] + arguments[r] * left[i + 1];
  return left[0];
}
/// The blossom of a polynomial by its degree + 1 Bezier points. Loops of known length take half the
/// time.
template <class Point>
[[nodiscard]] inline Point bezier_blossom(const Point* points, std::size_t degree,
                                          const BlossomArguments& arguments) {
  if (degree == 2) return bezier_blossom<2>(points, arguments);
  return degree == 3 ? bezier_blossom<3>(points, arguments) : bezier_blossom<1>(points, arguments);
}

/// Bezier points of a polynomial in two variables: (i, j) at i + (degree + 1) j.
using PointNet = std::array<glm::dvec3, (kMostSplineDegree + 1) * (kMostSplineDegree + 1)>;

/// A polynomial over a square of a corner's (u, v), in unit coordinates.
struct SquarePiece {
  double u = 0, v = 0, size = 1;
  std::size_t degree = 2;
  PointNet net{};

  [[nodiscard]] std::size_t net_size() const { return (degree + 1) * (degree + 1); }
  [[nodiscard]] bool holds(double at_u, double at_v) const {
    return at_u >= u && at_u <= u + size && at_v >= v && at_v <= v + size;
  }
  [[nodiscard]] glm::dvec3 blossom(const BlossomArguments& along_u,
                                   const BlossomArguments& along_v) const {
    return degree == 2 ? blossom_of<2>(along_u, along_v) : blossom_of<3>(along_u, along_v);
  }
  /// Bezier points over a part of it, whose ends may be swapped.
  [[nodiscard]] PointNet part(double from_u, double to_u, double from_v, double to_v) const {
    PointNet points{};
    for (std::size_t j = 0; j <= degree; ++j) {
      const BlossomArguments along_v = bezier_arguments(degree, j, from_v, to_v);
      for (std::size_t i = 0; i <= degree; ++i)
        points[i + (degree + 1) * j] = blossom(bezier_arguments(degree, i, from_u, to_u), along_v);
    }
    return points;
  }

 private:
  template <std::size_t kDegree>
  [[nodiscard]] glm::dvec3 blossom_of(const BlossomArguments& along_u,
                                      const BlossomArguments& along_v) const {
    BlossomArguments s{}, t{};
    for (std::size_t k = 0; k < kDegree; ++k) {
      s[k] = (along_u[k] - u) / size;
      t[k] = (along_v[k] - v) / size;
    }
    std::array<glm::dvec3, kDegree + 1> row;
    for (std::size_t j = 0; j <= kDegree; ++j)
      row[j] = bezier_blossom<kDegree>(&net[(kDegree + 1) * j], s);
    return bezier_blossom<kDegree>(row.data(), t);
  }
};

/// A corner's patch, over its quad of Q_1: from its vertex V at (0, 0) to its face's centre F at
/// (1, 1), u along the leading edge. All points are in unit coordinates (see Placement).
class SplinePatch {
 public:
  /// A place where no polynomial is, however small: V, or F.
  struct End {
    bool is_face = false;
    glm::dvec3 limit{};
  };
  struct Point {
    glm::dvec3 position{}, normal{};  ///< the normal not of unit length
  };

  virtual ~SplinePatch() = default;
  virtual void move_to(std::int32_t corner) = 0;
  /// The surface itself, at ends too.
  [[nodiscard]] virtual Point at(double u, double v) = 0;
  /// Adds the polynomials that cover the patch but for squares of 2^-depth at its ends, and these.
  /// `depths`: at V and F, at least 1.
  virtual void add_pieces(const std::array<int, 2>& depths, std::vector<SquarePiece>& pieces,
                          std::vector<End>& ends) = 0;
};

/// A surface that consists of tensor-product polynomials, those of regular quads of Q_1 and, at
/// extraordinary points, those of squares that halve: C1 of degree 2, or C2 of degree 3.
class SplineSurface {
 public:
  virtual ~SplineSurface() = default;
  [[nodiscard]] virtual std::size_t degree() const = 0;
  [[nodiscard]] virtual const MeshTopology& topology() const = 0;
  [[nodiscard]] virtual const Placement& placement() const = 0;
  /// One flag a face where some are not shown, else nothing.
  [[nodiscard]] virtual std::span<const std::uint8_t> hidden() const = 0;
  /// Of a corner's leading edge: whether normals jump there.
  [[nodiscard]] virtual bool is_sharp(std::int32_t corner) const = 0;
  /// Whether no polynomial is at a corner's vertex, however small.
  [[nodiscard]] virtual bool is_singular_at_vertex(std::int32_t corner) const = 0;
  /// Which can be moved; must not outlive the surface.
  [[nodiscard]] virtual std::unique_ptr<SplinePatch> patch() const = 0;
};

}  // namespace planish
