#include "planish/brep/doo_sabin_splines.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planish/core/assert.h"
#include "planish/limit/bezier_net.h"
#include "planish/limit/patch_frame.h"

namespace planish {
namespace {

// A polynomial of a frame, as the patch around it sees it.
SquarePiece in_patch(const PatchFrame& frame, const BezierNet& net, const glm::dvec3& own) {
  const glm::dvec2 a = frame.at(0, 0), b = frame.at(1, 1);
  SquarePiece piece;
  piece.u = std::min(a.x, b.x);
  piece.v = std::min(a.y, b.y);
  piece.size = frame.size;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      const double du = (piece.u - frame.u) / frame.size + 0.5 * i;
      const double dv = (piece.v - frame.v) / frame.size + 0.5 * j;
      const auto x = static_cast<std::size_t>(std::lround(2 * (frame.c * du + frame.s * dv)));
      const auto y = static_cast<std::size_t>(std::lround(2 * (frame.c * dv - frame.s * du)));
      piece.net[i + 3 * j] = own + net[x + 3 * y];
    }
  }
  return piece;
}

class DooSabinPatch : public SplinePatch {
 public:
  explicit DooSabinPatch(const LimitSurface& surface) : corner_(surface) {}

  void move_to(std::int32_t corner) override { corner_.move_to(corner); }
  Point at(double u, double v) override {
    const PatchPoint point = corner_.at({u, v});
    return {point.position, point.normal};
  }
  void add_pieces(const std::array<int, 2>& depths, std::vector<SquarePiece>& pieces,
                  std::vector<End>& ends) override {
    const PatchForm& form = corner_.form();
    if (form.is_polynomial()) {
      pieces.push_back(in_patch({}, bezier_net(form, corner_.points()), corner_.own()));
      return;
    }
    std::vector<glm::dvec3> points;
    for (const int q : {1, 3, 0, 2}) {
      quarter_points(form, q, corner_.points(), points);
      const PatchForm& inner = *form.quarters[q];
      if (inner.is_polynomial()) {
        pieces.push_back(
            in_patch(PatchFrame().quarter(q), bezier_net(inner, points), corner_.own()));
      } else {
        PLANISH_ASSERT(q == 0 || q == 2);
        ends.push_back({q == 2, add_rings(inner, q, depths[q == 0 ? 0 : 1], points, pieces)});
      }
    }
  }

 private:
  // Of a quarter that is no polynomial; returns its limit point.
  [[nodiscard]] glm::dvec3 add_rings(const PatchForm& end, int quarter, int depth,
                                     std::vector<glm::dvec3> points,
                                     std::vector<SquarePiece>& pieces) const {
    const PatchForm* form = &end;
    PatchFrame frame = PatchFrame().quarter(quarter);
    std::vector<glm::dvec3> next;
    for (int d = 1; d < depth; ++d) {
      for (int q = 1; q < 4; ++q) {
        quarter_points(*form, q, points, next);
        const PatchForm& inner = *form->quarters[q];
        pieces.push_back(in_patch(frame.quarter(q), bezier_net(inner, next), corner_.own()));
      }
      quarter_points(*form, 0, points, next);
      std::swap(points, next);
      form = form->quarters[0];
      frame = frame.quarter(0);
    }
    glm::dvec3 limit = corner_.own();
    for (std::size_t k = 0; k < points.size(); ++k) limit += form->corner[k] * points[k];
    return limit;
  }

  LimitSurface::Corner corner_;
};

}  // namespace

std::unique_ptr<SplinePatch> DooSabinSplines::patch() const {
  return std::make_unique<DooSabinPatch>(surface_);
}

}  // namespace planish
