#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/limit/corner_tree.h"
#include "planish/limit/patch_pieces.h"

namespace planish {

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
