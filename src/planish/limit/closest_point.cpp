#include "planish/limit/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <utility>

namespace planish {
namespace {

constexpr int kMostDescents = 100;
constexpr int kMostCuts = 2;             // of a piece, for more starts
constexpr double kSmallStep = 1e-14;     // in u and v
constexpr double kSmallestShare = 1e-7;  // of a step
constexpr double kBorder = 1e-12;        // in u and v: on the border

// What a step of Newton's method is made of: the square distance, and half its gradient and
// Hessian.
struct Descent {
  double value = 0, gu = 0, gv = 0, huu = 0, huv = 0, hvv = 0;
  double least = 0;  // what second derivatives count for at least

  Descent(const PatchPoint& p, const glm::dvec3& target) {
    const glm::dvec3 off = p.position - target;
    value = glm::dot(off, off);
    gu = glm::dot(off, p.du);
    gv = glm::dot(off, p.dv);
    const double e = glm::dot(p.du, p.du), g = glm::dot(p.dv, p.dv);
    huu = e + glm::dot(off, p.duu);
    huv = glm::dot(p.du, p.dv) + glm::dot(off, p.duv);
    hvv = g + glm::dot(off, p.dvv);
    least = 1e-6 * (e + g);
  }

  // Downhill along both: where the distance is not convex in a direction, its second derivative
  // there counts by magnitude, so that steps lead away from saddles.
  [[nodiscard]] glm::dvec2 step() const {
    const double middle = 0.5 * (huu + hvv), half = 0.5 * (huu - hvv);
    const double root = std::hypot(half, huv);
    const double turn = 0.5 * std::atan2(huv, half);
    const glm::dvec2 first(std::cos(turn), std::sin(turn)), second(-first.y, first.x);
    const glm::dvec2 gradient(gu, gv);
    return -glm::dot(gradient, first) / size(middle + root) * first -
           glm::dot(gradient, second) / size(middle - root) * second;
  }
  [[nodiscard]] double step_u() const { return -gu / size(huu); }
  [[nodiscard]] double step_v() const { return -gv / size(hvv); }

 private:
  [[nodiscard]] double size(double second) const { return std::max(std::abs(second), least); }
};

bool is_blocked(double t, double gradient) {
  return (t <= 0 && gradient >= 0) || (t >= 1 && gradient <= 0);
}

double on_border(double t) {
  if (t < kBorder) return 0;
  if (t > 1 - kBorder) return 1;
  return t;
}

}  // namespace

// Newton's method in a piece: steps end at its borders, and go along them where the distance falls
// outwards. Nothing of the surface bends abruptly on the way.
void NearestSearch::descend(const PatchPiece& piece, double u, double v, const glm::dvec3& point) {
  Descent here(piece.at(u, v), point);
  for (int step = 0; step < kMostDescents; ++step) {
    const bool fixed_u = is_blocked(u, here.gu), fixed_v = is_blocked(v, here.gv);
    double du = 0, dv = 0;
    if (!fixed_u && !fixed_v) {
      const glm::dvec2 both = here.step();
      du = both.x;
      dv = both.y;
    } else if (!fixed_u) {
      du = here.step_u();
    } else if (!fixed_v) {
      dv = here.step_v();
    }
    // At a border, along it where the step would leave.
    const auto leaves = [](double t, double dt) {
      return (t <= 0 && dt < 0) || (t >= 1 && dt > 0);
    };
    const bool leaves_u = leaves(u, du), leaves_v = leaves(v, dv);
    if (leaves_u) du = 0;
    if (leaves_v) dv = 0;
    if (leaves_u && dv != 0) dv = here.step_v();
    if (leaves_v && du != 0) du = here.step_u();
    if (!(std::abs(du) + std::abs(dv) > kSmallStep)) break;  // NaN too: no tangents
    bool falls = false;
    for (double share = 1; share > kSmallestShare && !falls; share *= 0.5) {
      const double next_u = on_border(std::clamp(u + share * du, 0.0, 1.0));
      const double next_v = on_border(std::clamp(v + share * dv, 0.0, 1.0));
      const Descent next(piece.at(next_u, next_v), point);
      if (!(next.value < here.value)) continue;
      u = next_u;
      v = next_v;
      here = next;
      falls = true;
    }
    if (!falls) break;
  }
  take(here.value, piece.frame.at(u, v));
}

void NearestSearch::take(double square_distance, const glm::dvec2& place) {
  if (!(square_distance < best_.square_distance)) return;
  best_ = {corner_, place.x, place.y, square_distance};
}

// Boxes and planes are exact but for rounding.
bool NearestSearch::is_near(const PatchBox& box, const glm::dvec3& point) const {
  return square_distance(box, point) <= best_.square_distance * (1 + 1e-12);
}

// A start in the middle; where that may not do, one in each quarter that comes near enough.
void NearestSearch::search_piece(const PatchPiece& piece, const glm::dvec3& point, int cuts) {
  const double least = piece.least_distance(point) - 1e-15;
  if (least > 0 && least * least > best_.square_distance * (1 + 1e-12)) return;
  if (cuts == 0 || !piece.bends_around(point)) return descend(piece, 0.5, 0.5, point);
  for (const auto& [upper_u, upper_v] :
       {std::pair{false, false}, {true, false}, {false, true}, {true, true}}) {
    const PatchPiece part = piece.half(upper_u, upper_v);
    if (is_near(part.box(), point)) search_piece(part, point, cuts - 1);
  }
}

// A start in each quarter that comes near enough: a patch can have a nearest place of its own in
// each. Where a quarter is no polynomial, one in each polynomial of it.
void NearestSearch::search_corner(std::int32_t corner, const glm::dvec3& target) {
  corner_ = corner;
  pieces_.move_to(corner);
  struct Start {
    double square_distance;
    std::size_t quarter;
  };
  std::array<Start, 4> starts;
  const glm::dvec3 point = target - pieces_.corner().own();
  for (std::size_t q = 0; q < 4; ++q) starts[q] = {square_distance(pieces_.box(q), point), q};
  std::ranges::sort(starts, {}, &Start::square_distance);
  for (const auto& [_, q] : starts) {
    if (!is_near(pieces_.box(q), point)) break;
    if (const PatchPiece* const piece = pieces_.piece(q)) {
      search_piece(*piece, point, kMostCuts);
    } else {
      pieces_.visit(
          q,
          [&](const glm::dvec3& vertex, const PatchFrame& frame) {
            const glm::dvec3 off = vertex - point;
            take(glm::dot(off, off), frame.at(0, 0));
          },
          [&](const PatchPiece& inner) {
            if (is_near(inner.box(), point)) search_piece(inner, point, kMostCuts);
          },
          [&](const PatchBox& box) { return is_near(box, point); });
    }
  }
}

NearestPlace NearestSearch::run(const glm::dvec3& point) {
  best_ = {.corner = -1, .square_distance = std::numeric_limits<double>::infinity()};
  const auto& nodes = tree_.nodes();
  waiting_.assign(1, {0, square_distance(nodes[0].box, point)});
  while (!waiting_.empty()) {
    const Waiting next = waiting_.back();
    waiting_.pop_back();
    if (next.square_distance >= best_.square_distance) continue;
    const CornerTree::Node& node = nodes[static_cast<std::size_t>(next.node)];
    if (node.count > 0) {
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (square_distance(tree_.boxes()[at], point) < best_.square_distance)
          search_corner(tree_.corners()[at], point);
      }
      continue;
    }
    Waiting left{next.node + 1, 0}, right{node.right, 0};
    left.square_distance = square_distance(nodes[static_cast<std::size_t>(left.node)].box, point);
    right.square_distance = square_distance(nodes[static_cast<std::size_t>(right.node)].box, point);
    // The nearer one is looked at first.
    if (left.square_distance < right.square_distance) std::swap(left, right);
    waiting_.push_back(left);
    waiting_.push_back(right);
  }
  return best_;
}

}  // namespace planish
