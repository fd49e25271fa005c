#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/brep/brep.h"
#include "planish/brep/quad_layout.h"
#include "planish/brep/spline_surface.h"
#include "planish/core/callbacks.h"

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

/// What the control points beside the limit point are moved by, seen from an extraordinary point:
/// of the border along x, c_10, of that along y, c_01, and c_11 inside. Those of borders are the
/// same for both sides.
struct CapMove {
  glm::dvec3 along_x{}, along_y{}, inside{};
};

/// Basis functions on knots 0 (degree + 1 times), 1, 2, in squares of 2^-depth: that of the limit
/// point, not 0 in [0, 1), and that of c_10 along x, not 0 in (0, 2).
class CapBasis {
 public:
  explicit CapBasis(std::size_t degree) : degree_(degree), last_(degree == 2 ? 0.5 : 0.25) {}

  [[nodiscard]] double limit(double t) const { return t < 1 ? power(1 - t, degree_) : 0; }
  [[nodiscard]] double beside(double t) const {
    if (t >= 1) return t < 2 ? last_ * power(2 - t, degree_) : 0;
    return degree_ == 2 ? 2 * t - 1.5 * t * t : 3 * t - 4.5 * t * t + 1.75 * t * t * t;
  }
  /// The derivative of beside(), by the degree.
  [[nodiscard]] double beside_slope(double t) const {
    if (t >= 1) return t < 2 ? -last_ * power(2 - t, degree_ - 1) : 0;
    return degree_ == 2 ? 1 - 1.5 * t : 1 - 3 * t + 1.75 * t * t;
  }
  /// What a place moves by, x and y in squares of 2^-depth from the point.
  [[nodiscard]] glm::dvec3 moved_by(const CapMove& move, double x, double y) const {
    const double x1 = beside(x), y1 = beside(y);
    return x1 * limit(y) * move.along_x + limit(x) * y1 * move.along_y + x1 * y1 * move.inside;
  }
  /// Moves the polynomial on [x, x + size] x [y, y + size], which has no square's border inside.
  void add_move(const CapMove& move, double x, double y, double size, PointNet& net) const;

 private:
  static double power(double base, std::size_t exponent) {
    return exponent == 3 ? base * base * base : exponent == 2 ? base * base : base;
  }
  // Of the polynomials of the square that holds t.
  [[nodiscard]] double limit_blossom(double t, const BlossomArguments& arguments) const;
  [[nodiscard]] double beside_blossom(double t, const BlossomArguments& arguments) const;

  std::size_t degree_;
  double last_;  ///< of beside() at 1
};

/// A corner's patch as polynomials that cover it. Where it has a point in no polynomial, at its
/// vertex V or its face's centre F, the square of 2^-depth there has the one polynomial of the
/// surface's degree that joins its neighbours as smoothly as these one another, passes through the
/// limit point, and whose borders depend on nothing but the surface on them.
class CornerPieces {
 public:
  /// Depths at V and F are at least 1; the patch has been moved to its corner.
  CornerPieces(SplinePatch& patch, std::size_t degree, const std::array<int, 2>& depths);

  /// Moves the points beside the limit point at V, or that at F, whose depth it was made with.
  void move(const CapMove& move, bool is_face, int depth);

  [[nodiscard]] const SquarePiece& at(double u, double v) const;

 private:
  void add_cap(const SplinePatch::End& end, int depth);

  std::size_t degree_;
  std::vector<SquarePiece> pieces_;
};

struct CapLimits {
  double angle = 0.25;      ///< degrees between normals across an edge
  double deviation = 1e-6;  ///< along the normal, of the diagonal
};

/// What squares at an extraordinary point leave.
struct CapError {
  double angle = 0;                   ///< degrees between normals across edges
  double deviation = 0;               ///< of the diagonal
  Brep::Spot angle_at, deviation_at;  ///< in unit coordinates

  void add_angle(double other, const Brep::Spot& spot) {
    if (other <= angle) return;
    angle = other;
    angle_at = spot;
  }
  void add_deviation(double other, const Brep::Spot& spot) {
    if (other <= deviation) return;
    deviation = other;
    deviation_at = spot;
  }
  void add(const CapError& other) {
    add_angle(other.angle, other.angle_at);
    add_deviation(other.deviation, other.deviation_at);
  }
  /// At most 1 where both limits are kept.
  [[nodiscard]] double part_of(const CapLimits& limits) const {
    return std::max(angle / limits.angle, deviation / limits.deviation);
  }
};

/// How far the squares at extraordinary points are halved, where points beside these are moved, and
/// what that reaches.
struct CapDepths {
  std::vector<std::int8_t> of_vertex;  ///< by vertex of Q_1; 1 where nothing is to be halved
  std::vector<CapMove> moves;
  /// By corner, at its vertex V and its face's centre F: which of the moves; -1: none.
  std::vector<std::array<std::int32_t, 2>> of_corner;
  std::int64_t count = 0, moved = 0;  ///< extraordinary points, and those with moves
  int deepest = 0;
  CapError worst;
};

/// A corner's polynomials with the depths and moves at its V and F, or at F alone.
[[nodiscard]] CornerPieces pieces_of(SplinePatch& patch, std::int32_t corner,
                                     const QuadLayout& layout, const CapDepths& depths);

/// Measures the squares around one extraordinary point after another, and moves points beside it.
class CapMeasure {
 public:
  /// `depths`: what was chosen at centres of faces, which choices at vertices take for given.
  CapMeasure(const SplineSurface& surface, const QuadLayout& layout, const CapDepths& depths)
      : surface_(surface),
        layout_(layout),
        depths_(depths),
        patch_(surface.patch()),
        basis_(surface.degree()) {}

  /// Squares of 2^-depth around a vertex of the mesh or, of a face, around its centre: `corners`
  /// are all of it, counter-clockwise. What is within the limits, or `is_final`, is a bound over
  /// all places; of the rest some are looked at, which show that it is not.
  CapError of(std::span<const std::int32_t> corners, bool is_face, int depth,
              const CapLimits& limits, bool is_final);

  /// The same squares after moves along the limit point's normal, of c_10, c_01 and c_11, that let
  /// normals across the edges and the surface agree best: so that the largest part of a limit that
  /// an angle or a deviation takes is small. False where nothing is to be moved:
  /// at boundaries, sharp edges, and around less than 3 or more than kMostMovedCorners. Of bounds
  /// as of().
  bool move(const CapLimits& limits, bool is_final, CapError& moved);
  /// By corner, where move() was true.
  [[nodiscard]] std::span<const CapMove> moves() const { return moves_; }

  static constexpr std::size_t kMostMovedCorners = 64;

 private:
  // The squares of a corner that moves change, turned to have the point at (0, 0) of the first.
  struct Cap {
    std::size_t degree = 2;
    PointNet inside{}, beside_x{}, beside_y{};

    // Derivatives, by the degree, along and across a border at t in [0, 2], in squares.
    struct Border {
      glm::dvec3 line, along, side;

      [[nodiscard]] double turned_by_rounding(const glm::dvec3& normal) const {
        return planish::turned_by_rounding(glm::length(along), glm::length(side),
                                           glm::length(normal));
      }
    };
    [[nodiscard]] Border border(bool along_y, double t) const;
    void add(const CapBasis& basis, const CapMove& move);
  };
  // A place, how far the squares are from the exact surface there, and its normal; 0: any.
  struct Place {
    double x = 0, y = 0;
    glm::dvec3 apart{}, normal{};
  };
  // A square of the exact surface, and by how far the written one is from it before moves.
  struct Check {
    double x = 0, y = 0, size = 1;  // in squares from the point
    Brep::Spot middle;
    PieceBound exact;
    PointNet apart{};
  };

  void add_places(std::int32_t corner, int depth, const CornerPieces& pieces,
                  std::vector<Place>& places);
  void add_square(const SquarePiece& piece, bool is_at_face, int depth, std::vector<Place>& places);
  [[nodiscard]] CornerPieces written_pieces(std::int32_t corner);
  void add_checks(std::int32_t corner, std::vector<Check>& checks);
  template <class Use>
  void for_edges(const Use& use) const;
  [[nodiscard]] static MeetingSides sides(const Cap& cap, const Cap& other, bool is_beside);
  [[nodiscard]] double sampled_angle(double until) const;
  // Where it is not final no more is looked at than shows that limits are not kept.
  [[nodiscard]] CapError bound(std::span<const CapMove> moves, const CapLimits& limits,
                               bool is_final);
  [[nodiscard]] bool can_move() const;
  void improve_moves(const glm::dvec3& normal, const CapLimits& limits, double largest_part);
  [[nodiscard]] CapError moved_error() const;

  const SplineSurface& surface_;
  const QuadLayout& layout_;
  const CapDepths& depths_;
  std::unique_ptr<SplinePatch> patch_;
  CapBasis basis_;
  std::vector<std::int32_t> corners_;
  bool is_face_ = false;
  int depth_ = 1;
  glm::dvec3 point_{};
  std::vector<Cap> caps_;
  std::vector<std::vector<Check>> checks_;  // by corner, made when first asked for
  std::vector<std::vector<Place>> places_;  // by corner, the first kOwnPlaces of its own square
  std::vector<CapMove> moves_;
  std::vector<double> weights_;
};

constexpr int kDeepestCap = 12;

/// The smallest depths, to kDeepestCap, that keep the limits, with moves where they let a depth
/// be smaller. Reports step
/// "faces" from 0 to 1.
[[nodiscard]] CapDepths cap_depths(const SplineSurface& surface, const QuadLayout& layout,
                                   const CapLimits& limits, const Callbacks& callbacks);

}  // namespace planish
