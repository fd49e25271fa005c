#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/patches/bezier_net.h"
#include "planish/patches/patch_form.h"
#include "planish/queries/limit_surface.h"
#include "planish/queries/surface_queries.h"

namespace planish {

/// A polynomial that a patch or a part of it is, its points relative to the corner's own.
struct PatchPiece {
  BezierNet net{};
  PatchFrame frame;

  /// By the piece's own (u, v) in [0, 1]^2.
  [[nodiscard]] PatchPoint at(double own_u, double own_v) const;
  /// No point of it is nearer to `point`, by a plane across the way to its middle; 0 where that
  /// tells nothing.
  [[nodiscard]] double least_distance(const glm::dvec3& point) const;
  [[nodiscard]] PatchBox box() const;
  /// A quarter, not turned.
  [[nodiscard]] PatchPiece half(bool upper_u, bool upper_v) const;
};

/// What a halving of a quarter that is no polynomial leaves: three polynomials, and the rest around
/// its vertex V.
struct PatchRing {
  std::array<PatchPiece, 3> pieces;
  std::array<PatchBox, 3> boxes;
  PatchBox rest;
};

/// The polynomials that a corner's patch consists of, by halves, ready to be asked often. Keeps its
/// room from corner to corner.
class PatchPieces {
 public:
  PatchPieces(const LimitSurface& surface, const PatchReaches& reaches)
      : corner_(surface), reaches_(reaches) {}

  void move_to(std::int32_t corner);
  [[nodiscard]] glm::dvec3 own() const { return corner_.own(); }
  /// Around quarter 0 to 3, relative to the corner's own point.
  [[nodiscard]] const PatchBox& box(std::size_t quarter) const { return boxes_[quarter]; }
  /// Of a quarter; null where it is no polynomial.
  [[nodiscard]] const PatchPiece* piece(std::size_t quarter) const {
    return has_piece_[quarter] ? &pieces_[quarter] : nullptr;
  }
  /// The limit point at V of a quarter that is no polynomial, and where it lies.
  [[nodiscard]] const glm::dvec3& vertex(std::size_t quarter) const {
    return inside_[quarter].vertex;
  }
  [[nodiscard]] static PatchFrame vertex_frame(std::size_t quarter) {
    return PatchFrame().quarter(static_cast<int>(quarter));
  }
  /// Of such a quarter, outwards in: by halving 0, 1, ...; null after the last. Made when asked
  /// for.
  [[nodiscard]] const PatchRing* ring(std::size_t quarter, std::size_t halving);

 private:
  // A quarter that is no polynomial, as far as it was asked for.
  struct Inside {
    glm::dvec3 vertex{0.0};
    std::vector<PatchRing> rings;
    // What the rings leave.
    const PatchForm* form = nullptr;
    PatchFrame frame;
    std::vector<glm::dvec3> points;
  };
  void enter(std::size_t quarter, const PatchForm& form);

  LimitSurface::Corner corner_;
  const PatchReaches& reaches_;
  std::int32_t at_ = -1;  // the corner that pieces and boxes are of
  std::array<PatchPiece, 4> pieces_{};
  std::array<bool, 4> has_piece_{};
  std::array<PatchBox, 4> boxes_{};
  std::array<Inside, 4> inside_;
  std::vector<glm::dvec3> points_;
};

/// The nearest place of a surface in unit coordinates.
struct NearestPlace {
  std::int32_t corner = -1;
  double u = 0, v = 0;
  double square_distance = 0;
};

/// Searches a tree for the place nearest to a point, both in unit coordinates: none is nearer by
/// more than 1e-13, or 2e-15 of the distance; where faces are all but lines, and a search would not
/// end, by ten or a hundred times as much. Used again from point to point; one a thread.
class NearestSearch {
 public:
  /// Keeps the pieces of so many corners from point to point: of one, or where points come in the
  /// order of space, and so ask for the same corners, of kManyCorners.
  explicit NearestSearch(const CornerTree& tree, std::size_t kept_corners = 1)
      : tree_(tree), kept_(kept_corners, PatchPieces(tree.surface(), tree.reaches())) {}

  static constexpr std::size_t kManyCorners = 64;

  [[nodiscard]] NearestPlace run(const glm::dvec3& point);
  /// Corners, and regions of their pieces, that the last run has looked at: what it took, on any
  /// machine.
  [[nodiscard]] std::int64_t work() const { return corner_count_ + region_count_; }

 private:
  void search_corner(std::int32_t corner, const glm::dvec3& target);
  // Points relative to the corner's own from here on.
  struct Region;
  void search_piece(const PatchPiece& piece, const glm::dvec3& point);
  void search_waiting_pieces();
  [[nodiscard]] bool is_far(const Region& region) const;
  [[nodiscard]] bool is_beyond(double distance) const;
  void search_region(const PatchPiece& piece, Region region, const glm::dvec3& point);
  bool search_sheet(const PatchPiece& piece, const Region& region, const glm::dvec3& point);
  void want();
  struct Lowest;
  static Lowest lowest_in(const PatchPiece& piece, const Region& region, const glm::dvec2& start,
                          const glm::dvec3& point);
  bool descend(const PatchPiece& piece, const Region& region, const glm::dvec3& point);
  void take(double square_distance, const glm::dvec2& place);
  [[nodiscard]] bool is_near(const PatchBox& box, const glm::dvec3& point) const;

  const CornerTree& tree_;
  std::vector<PatchPieces> kept_;  // by the corner's last digits
  struct Waiting {
    std::int32_t node;
    double square_distance;
  };
  std::vector<Waiting> waiting_;
  struct WaitingPiece {
    std::int32_t corner;
    PatchPiece piece;
    glm::dvec3 point;
  };
  std::vector<WaitingPiece> split_later_;
  std::int32_t corner_ = -1;  // that is searched
  NearestPlace best_;
  double absolute_ = 0;  // what it may be too far by
  std::int64_t corner_count_ = 0, region_count_ = 0;
  double wanted_ = 0;  // the square distance below which a place would be nearer enough to matter
};

}  // namespace planish
