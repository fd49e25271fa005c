#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>

#include "planish/brep/square_piece.h"

namespace planish {

// Bounds over all places, not the largest of some: polynomials lie within their Bezier points, and
// so do products of them.

/// The surface over a square, where it is a polynomial.
class PieceBound {
 public:
  explicit PieceBound(const SquarePiece& piece);

  /// From the surface, of any place of another polynomial over the square; `apart`: Bezier points
  /// of the other less this one. What these do not have along normals counts to second order, by
  /// the curvature. At least `known`.
  [[nodiscard]] double distance(const PointNet& apart, double known) const;

 private:
  [[nodiscard]] double along_normals(const PointNet& apart) const;

  static constexpr std::size_t kMostNormals = 4 * kMostSplineDegree * kMostSplineDegree,
                               kMostProducts = 9 * kMostSplineDegree * kMostSplineDegree;

  std::size_t degree_;
  std::array<glm::dvec3, kMostNormals> normals_{};  // Bezier points of the cross product
  std::array<double, kMostProducts> along_{};       // of the normals along the axis, degrees raised
  glm::dvec3 axis_{};                               // among them
  double least_ = 0;                                // of the normals along it
  double thickness_ = 0;                            // of the piece along it
  double curvature_ = 0;                            // at the piece's corners, the largest
};

/// Two polynomials at a border that both have, over the same part of it, t in [0, 1]: Bezier points
/// of the border, and differences across it on either side.
struct MeetingSides {
  std::size_t degree = 2;
  std::array<glm::dvec3, kMostSplineDegree + 1> line{}, left{}, right{};
};

/// How far normals jump across a border, at most.
struct Jump {
  double angle = 0;       ///< radians
  glm::dvec3 position{};  ///< where

  void add(double other, const glm::dvec3& there) {
    if (other <= angle) return;
    angle = other;
    position = there;
  }
};

/// What rounding of coordinates, in unit coordinates, may turn a normal by that two derivatives
/// have; without limit where the cross product is none.
[[nodiscard]] double turned_by_rounding(double along, double across, double product);

/// Adds the largest jump of a border's part that begins at a vertex, or lies behind it: of where
/// normals are told by more than rounding, and not nearer to the vertex than Brep::kSamePlace.
void add_jump(const MeetingSides& sides, const glm::dvec3& vertex, Jump& largest);

}  // namespace planish
