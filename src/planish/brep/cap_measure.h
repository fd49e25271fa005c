#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/geometric.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/brep/brep.h"
#include "planish/brep/cap_bound.h"
#include "planish/brep/corner_pieces.h"
#include "planish/brep/quad_layout.h"

namespace planish {

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

}  // namespace planish
