#include "planish/limit/ray_search.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "planish/core/point_bounds.h"
#include "planish/limit/patch_box.h"

namespace planish {
namespace {

constexpr double kRounding = 1e-13;  // of the diagonal
// Splits until a piece that is neither met once nor not at all counts as touched.
constexpr int kDeepest = 36;
constexpr int kMostSteps = 30;
// Pieces of a corner after which no more are looked at: a ray in a plane patch meets more of them
// with every split, and has touched some by then.
constexpr int kMostNets = 1 << 16;
// From further away (of diagonals) differences are those of rounding: the ray begins nearer.
constexpr double kFarAway = 100;
constexpr double kOverlap = 1e-9;  // of a piece, so that none falls between two
// The same place as several pieces find it; where patches have no polynomial it is less exact.
constexpr double kSamePlace = 1e-10, kSameSingularPlace = 1e-6;

double cross(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.y - a.y * b.x; }

// Whether any two directions along u and v turn the same way as the ray sees them: the piece is
// then seen without folds, and no two of its points in one place.
bool is_seen_once(const BezierNet& net) {
  std::array<glm::dvec3, 6> du, dv;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      du[2 * i + k] = net[3 * i + k + 1] - net[3 * i + k];
      dv[2 * i + k] = net[3 * (k + 1) + i] - net[3 * k + i];
    }
  }
  const bool positive = cross(du[0], dv[0]) > 0;
  for (const glm::dvec3& a : du) {
    for (const glm::dvec3& b : dv) {
      const double turn = cross(a, b);
      if (positive ? !(turn > 0) : !(turn < 0)) return false;
    }
  }
  return true;
}

// Whether the ray passes beside a piece, across the longer of its diagonals as the ray sees it: of
// a piece that is nearly seen from its edge the box is much larger than it.
bool is_beside(const BezierNet& net) {
  const glm::dvec3 a = net[8] - net[0], b = net[6] - net[2];
  const glm::dvec3& along = a.x * a.x + a.y * a.y > b.x * b.x + b.y * b.y ? a : b;
  const double size = std::hypot(along.x, along.y);
  double least = cross(along, net[0]), most = least;
  for (const glm::dvec3& p : net) {
    least = std::min(least, cross(along, p));
    most = std::max(most, cross(along, p));
  }
  return least > kRounding * size || most < -kRounding * size;
}

struct NetPoint {
  glm::dvec3 value{}, du{}, dv{};
};

NetPoint net_point(const BezierNet& net, double u, double v) {
  const auto basis = [](double t) { return std::array{(1 - t) * (1 - t), 2 * t * (1 - t), t * t}; };
  const auto slope = [](double t) { return std::array{2 * (t - 1), 2 - 4 * t, 2 * t}; };
  const auto bu = basis(u), bv = basis(v), su = slope(u), sv = slope(v);
  NetPoint result;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3& p = net[3 * j + i];
      result.value += bu[i] * bv[j] * p;
      result.du += su[i] * bv[j] * p;
      result.dv += bu[i] * sv[j] * p;
    }
  }
  return result;
}

}  // namespace

bool RaySearch::meets(const CornerBox& box) const {
  double from = t_min_ - kRounding, to = t_max_ + kRounding;
  for (int d = 0; d < 3; ++d) {
    const double low = box.low[d] - kRounding - turned_origin_[d];
    const double high = box.high[d] + kRounding - turned_origin_[d];
    if (turned_direction_[d] == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    const double a = low / turned_direction_[d], b = high / turned_direction_[d];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from <= to;
}

bool RaySearch::can_meet(std::span<const glm::dvec3> points, double reach) const {
  auto [low, high] = point_bounds(points);
  const glm::dvec3 more = 0.5 * (reach - 1) * (high - low) + glm::dvec3(kRounding);
  low -= more;
  high += more;
  return low.x <= 0 && high.x >= 0 && low.y <= 0 && high.y >= 0 && low.z <= t_max_ &&
         high.z >= t_min_;
}

void RaySearch::add(const PatchFrame& frame, const glm::dvec2& local, bool is_tangent,
                    bool is_singular) {
  const glm::dvec2 at = frame.at(local.x, local.y);
  RayPlace place;
  place.corner = corner_number_;
  place.u = std::clamp(at.x, 0.0, 1.0);
  place.v = std::clamp(at.y, 0.0, 1.0);
  const PatchPoint point = corner_.at({place.u, place.v});
  place.t = glm::dot(point.position - origin_, direction_);
  place.normal = point.normal;
  place.is_tangent = is_tangent;
  place.is_singular = is_singular;
  if (place.t < t_min_ || place.t > t_max_) return;
  if (wanted_ == RayAnswer::First) {
    t_max_ = place.t;
    places_.clear();
  }
  places_.push_back(place);
}

// Newton's method. False where it settles outside or not at all: the piece may be met all the same,
// since its polynomial folds outside it.
bool RaySearch::solve(const BezierNet& net, const PatchFrame& frame) {
  glm::dvec2 at(0.5);
  for (int step = 0; step < kMostSteps; ++step) {
    const NetPoint p = net_point(net, at.x, at.y);
    const double det = cross(p.du, p.dv);
    if (det == 0) return false;
    const glm::dvec2 change(-cross(p.value, p.dv) / det, -cross(p.du, p.value) / det);
    const glm::dvec2 next = glm::clamp(at + change, glm::dvec2(-1), glm::dvec2(2));
    const double moved = glm::length(next - at);
    at = next;
    if (moved > 1e-13) continue;
    const bool inside =
        at.x >= -kOverlap && at.x <= 1 + kOverlap && at.y >= -kOverlap && at.y <= 1 + kOverlap;
    if (inside) add(frame, at, false, false);
    return inside;
  }
  return false;
}

void RaySearch::search_net(const BezierNet& net, const PatchFrame& frame) {
  if (is_done() || !can_meet(net, 1) || is_beside(net)) return;
  if (is_seen_once(net) && solve(net, frame)) return;
  if (++pieces_ > kMostNets) return;
  if (frame.halvings() >= kDeepest) {
    add(frame, glm::dvec2(0.5), true, false);
    return;
  }
  for (const bool upper_v : {false, true}) {
    for (const bool upper_u : {false, true})
      search_net(net_quarter(net, upper_u, upper_v), frame.half(upper_u, upper_v));
  }
}

void RaySearch::search_form(const PatchForm& form, std::span<const glm::dvec3> points,
                            const PatchFrame& frame) {
  if (is_done()) return;
  if (form.is_polynomial()) {
    search_net(bezier_net(form, points), frame);
    return;
  }
  if (!can_meet(points, tree_.reaches().of(form))) return;
  if (frame.halvings() >= form.halvings) {
    add(frame, glm::dvec2(0.0), false, true);
    return;
  }
  std::vector<glm::dvec3> inner;
  for (int q = 0; q < 4; ++q) {
    quarter_points(form, q, points, inner);
    search_form(*form.quarters[q], inner, frame.quarter(q));
  }
}

void RaySearch::search_corner(std::int32_t corner) {
  pieces_ = 0;
  corner_number_ = corner;
  corner_.move_to(corner);
  std::vector<glm::dvec3> points;
  for (const glm::dvec3& p : corner_.points()) {
    const glm::dvec3 off = corner_.own() + p - origin_;
    points.emplace_back(glm::dot(off, right_), glm::dot(off, up_), glm::dot(off, direction_));
  }
  search_form(corner_.form(), points, {});
}

const std::vector<RayPlace>& RaySearch::run(const glm::dvec3& origin, const glm::dvec3& direction,
                                            double t_min, double t_max, RayAnswer wanted) {
  const CornerBox& all = tree_.nodes()[0].box;
  const glm::dvec3 centre = 0.5 * (glm::dvec3(all.low) + glm::dvec3(all.high));
  turned_direction_ = tree_.turned(direction);
  const double way = glm::dot(centre - tree_.turned(origin), turned_direction_);
  const double ahead = std::abs(way) > kFarAway ? way : 0;
  origin_ = origin + ahead * direction;
  direction_ = direction;
  turned_origin_ = tree_.turned(origin_);
  t_min_ = t_min - ahead;
  t_max_ = t_max - ahead;
  wanted_ = wanted;
  places_.clear();
  const glm::dvec3 size = glm::abs(direction);
  const glm::dvec3 least = size.x <= size.y && size.x <= size.z ? glm::dvec3(1, 0, 0)
                           : size.y <= size.z                   ? glm::dvec3(0, 1, 0)
                                                                : glm::dvec3(0, 0, 1);
  right_ = glm::normalize(glm::cross(direction, least));
  up_ = glm::cross(direction, right_);

  const auto& nodes = tree_.nodes();
  std::vector<std::int32_t> waiting{0};
  while (!waiting.empty() && !is_done()) {
    const CornerTree::Node& node = nodes[waiting.back()];
    const std::int32_t index = waiting.back();
    waiting.pop_back();
    if (!meets(node.box)) continue;
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (meets(tree_.boxes()[at])) search_corner(tree_.corners()[at]);
    }
    if (node.count > 0) continue;
    // The nearer half is looked at first.
    const auto middle = [&](std::int32_t child) {
      const CornerBox& box = nodes[child].box;
      return glm::dot(glm::dvec3(box.low) + glm::dvec3(box.high), turned_direction_);
    };
    std::int32_t near = index + 1, far = node.right;
    if (middle(far) < middle(near)) std::swap(near, far);
    waiting.push_back(far);
    waiting.push_back(near);
  }
  std::ranges::sort(places_, {}, &RayPlace::t);
  // What is found from both sides of a border is entered or left on both.
  const auto is_same = [&](const RayPlace& a, const RayPlace& b) {
    const double near = a.is_singular || b.is_singular ? kSameSingularPlace : kSamePlace;
    const bool same_way =
        (glm::dot(a.normal, direction) > 0) == (glm::dot(b.normal, direction) > 0);
    return b.t - a.t <= near && (same_way || a.is_tangent || b.is_tangent);
  };
  const auto last = std::unique(places_.begin(), places_.end(), is_same);
  places_.erase(last, places_.end());
  for (RayPlace& place : places_) place.t += ahead;
  return places_;
}

}  // namespace planish
