#include "planish/limit/fewest_cells.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/limit/bezier_net.h"

namespace planish {
namespace {

constexpr std::size_t kCornersTogether = 256;
// Cells turn with the surface, whose piece is seen along one normal here: so much less may do. And
// one cell may take in four corners.
constexpr double kSurelyNeeded = 0.25;

// Of a polynomial. A cell of a by b of its square is accepted where a^2 |S_uu| / 8 and
// b^2 |S_vv| / 8, along the normal, are within the distance; the least of each counts.
double cells_of_net(const BezierNet& net, double distance) {
  const glm::dvec3 across =
      glm::cross(net[2] - net[0] + net[8] - net[6], net[6] - net[0] + net[8] - net[2]);
  const double length = glm::length(across);
  if (!(length > 0)) return kSurelyNeeded;
  const glm::dvec3 normal = across / length;
  double uu = HUGE_VAL, vv = HUGE_VAL;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto second = [&](std::size_t a, std::size_t b, std::size_t c) {
      return std::abs(2 * glm::dot(net[a] - 2.0 * net[b] + net[c], normal));
    };
    uu = std::min(uu, second(3 * k, 3 * k + 1, 3 * k + 2));
    vv = std::min(vv, second(k, k + 3, k + 6));
  }
  const auto parts = [&](double value) { return std::max(1.0, std::sqrt(value / 8 / distance)); };
  return kSurelyNeeded * parts(uu) * parts(vv);
}

}  // namespace

double fewest_cells(const LimitSurface& surface, std::span<const std::uint8_t> hidden,
                    double distance) {
  const auto count = static_cast<std::size_t>(surface.topology().corner_count());
  std::vector<double> of_block((count + kCornersTogether - 1) / kCornersTogether, 0.0);
  parallel_for(of_block.size(), 1, [&](std::size_t begin, std::size_t end) {
    LimitSurface::Corner corner(surface);
    std::vector<glm::dvec3> points;
    for (std::size_t b = begin; b < end; ++b) {
      const std::size_t last = std::min(count, (b + 1) * kCornersTogether);
      for (std::size_t c = b * kCornersTogether; c < last; ++c) {
        if (hidden[c] != 0) continue;
        corner.move_to(static_cast<std::int32_t>(c));
        const PatchForm& form = corner.form();
        if (form.is_polynomial()) {
          of_block[b] += cells_of_net(bezier_net(form, corner.points()), distance);
          continue;
        }
        // A corner may be one cell: quarters count where they are more.
        double quarters = 0;
        for (int q = 0; q < 4; ++q) {
          const PatchForm& quarter = *form.quarters[q];
          if (!quarter.is_polynomial()) continue;
          quarter_points(form, q, corner.points(), points);
          const BezierNet net = bezier_net(quarter, points);
          quarters += std::max(0.0, cells_of_net(net, distance) - 1);
        }
        of_block[b] += 1 + quarters;
      }
    }
  });
  double sum = 0;
  for (const double cells : of_block) sum += cells;
  return sum;
}

}  // namespace planish
