#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/brep/brep.h"
#include "planish/brep/cap_depth.h"
#include "planish/brep/corner_pieces.h"
#include "planish/brep/quad_layout.h"

namespace planish {

/// The B-spline that a rectangle of quads is, and curves on its sides.
class SplineFace {
 public:
  /// All of it must outlive the face.
  SplineFace(const SplineSurface& surface, const QuadLayout& layout, const CapDepths& depths,
             std::int32_t rectangle);

  /// Sets knots and points. Lines of Q_1 on which polynomials go on are no knots.
  void fill(Brep::Face& face) const;
  /// Sets knots and points of the edge on quads [first, first + count) of a side, in its direction.
  void fill(Brep::Edge& edge, int side, std::int32_t first, std::int32_t count) const;
  [[nodiscard]] Brep::Line line(int side, std::int32_t first, std::int32_t count,
                                bool is_reversed) const;

 private:
  [[nodiscard]] glm::dvec3 blossom(glm::dvec2 inside, const BlossomArguments& x,
                                   const BlossomArguments& y) const;
  [[nodiscard]] std::vector<double> all_knots(bool along_y) const;
  [[nodiscard]] std::vector<double> needed(std::span<const double> knots,
                                           std::span<const double> others, bool along_y) const;

  const SplineSurface& surface_;
  const QuadLayout& layout_;
  const CapDepths& depths_;
  const QuadLayout::Rectangle& cells_;
  std::int32_t rectangle_;
  std::vector<CornerPieces> pieces_;  // by cell
  std::vector<double> knots_x_, knots_y_;
};

}  // namespace planish
