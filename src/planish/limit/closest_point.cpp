#include "planish/limit/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>

namespace planish {
namespace {

constexpr int kMostDescents = 100;
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

// Newton's method in the square: steps end at its borders, and go along them where the distance
// falls outwards.
void NearestSearch::descend(double u, double v, const glm::dvec3& point) {
  Descent here(pieces_.at(u, v), point);
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
      const Descent next(pieces_.at(next_u, next_v), point);
      if (!(next.value < here.value)) continue;
      u = next_u;
      v = next_v;
      here = next;
      falls = true;
    }
    if (!falls) break;
  }
  if (here.value < best_.square_distance) {
    best_.square_distance = here.value;
    best_.u = u;
    best_.v = v;
    best_.corner = -2;  // the one that is searched
  }
}

// A start in each quarter that comes near enough: a patch can have a nearest place of its own in
// each.
void NearestSearch::search_corner(std::int32_t corner, const glm::dvec3& point) {
  pieces_.move_to(corner, tree_.reaches());
  struct Start {
    double square_distance;
    std::size_t quarter;
  };
  std::array<Start, 4> starts;
  const glm::dvec3 off = point - pieces_.corner().own();
  for (std::size_t q = 0; q < 4; ++q) starts[q] = {square_distance(pieces_.box(q), off), q};
  std::ranges::sort(starts, {}, &Start::square_distance);
  for (const Start& start : starts) {
    // Boxes and planes are exact but for rounding.
    const double far = best_.square_distance * (1 + 1e-12);
    if (start.square_distance > far) break;
    const double least = pieces_.least_distance(start.quarter, off) - 1e-15;
    if (least > 0 && least * least > far) continue;
    descend(start.quarter % 2 == 1 ? 0.75 : 0.25, start.quarter >= 2 ? 0.75 : 0.25, point);
  }
  if (best_.corner == -2) best_.corner = corner;
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
