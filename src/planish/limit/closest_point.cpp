#include "planish/limit/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <utility>

#include "planish/limit/distance_net.h"
#include "planish/limit/sheet_bound.h"

namespace planish {
namespace {

constexpr int kMostDescents = 100;
constexpr double kSmallStep = 1e-14;     // in u and v
constexpr double kSmallestShare = 1e-7;  // of a step
constexpr double kLeastBend = 2e-6;      // what second derivatives along a way of 1 count for
constexpr double kBorder = 1e-12;        // of a region: on the border
// What an answer may be too far by: in unit coordinates, and of the distance.
constexpr double kAbsolute = 1e-13, kRelative = 2e-15;
// Regions that are searched before an answer may be too far by ten times as much: hundreds are
// common. Over faces that are lines but for 1e-12 of their length, whole curves of places are as
// near as one another, and cutting along u and v would follow them in steps of their width.
constexpr std::int64_t kPatience = 1 << 17;
// What a bound may be wrong by, of the largest square distance that it was made of.
constexpr double kBoundRounding = 2e-15;
// A bound is made again where it lost so much of that.
constexpr double kWorn = 1.0 / 8;

// By how much less the square of a distance does not matter.
double negligible(double square) {
  return 2 * (kAbsolute * std::sqrt(square) + kRelative * square);
}

// No place of a piece moves faster along u or v while that goes from 0 to 1.
double largest_speed(const BezierNet& net, bool along_v) {
  const std::size_t step = along_v ? 3 : 1, across = along_v ? 1 : 3;
  double largest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < 2; ++i) {
      const glm::dvec3& from = net[k * across + i * step];
      largest = std::max(largest, glm::length(net[k * across + (i + 1) * step] - from));
    }
  }
  return 2 * largest;
}

// What a step of Newton's method is made of: the square distance, and half its gradient and
// Hessian.
struct Descent {
  double value = 0, gu = 0, gv = 0, huu = 0, huv = 0, hvv = 0;
  double e = 0, f = 0, g = 0, area = 0;  // of the tangents: their products, and the area they span

  Descent(const PatchPoint& p, const glm::dvec3& target) {
    const glm::dvec3 off = p.position - target;
    value = glm::dot(off, off);
    gu = glm::dot(off, p.du);
    gv = glm::dot(off, p.dv);
    e = glm::dot(p.du, p.du);
    f = glm::dot(p.du, p.dv);
    g = glm::dot(p.dv, p.dv);
    area = glm::length(glm::cross(p.du, p.dv));
    huu = e + glm::dot(off, p.duu);
    huv = f + glm::dot(off, p.duv);
    hvv = g + glm::dot(off, p.dvv);
  }

  // Downhill along both, by ways on the surface rather than by parameters, which may run aslant and
  // unevenly. Where the distance is not convex in a direction, its second derivative there counts
  // by magnitude, so that steps lead away from saddles.
  [[nodiscard]] glm::dvec2 step() const {
    // Parameters of a way of 1 along the longer tangent, and of one across it.
    const bool is_u = e >= g;
    const glm::dvec2 first = (is_u ? glm::dvec2(1, 0) : glm::dvec2(0, 1)) / std::sqrt(is_u ? e : g);
    const glm::dvec2 second = across(is_u ? glm::dvec2(-f / e, 1) : glm::dvec2(1, -f / g),
                                     std::max(e, g), std::min(e, g));
    const glm::dvec2 gradient(gu, gv);
    const double g1 = glm::dot(gradient, first), g2 = glm::dot(gradient, second);
    const double h11 = bend(first, first), h12 = bend(first, second), h22 = bend(second, second);
    const double both = h11 * h22 - h12 * h12;
    if (h11 > 0 && both > kLeastBend * (h11 + h22))
      return (h12 * g2 - h22 * g1) / both * first + (h12 * g1 - h11 * g2) / both * second;
    const double middle = 0.5 * (h11 + h22), half = 0.5 * (h11 - h22);
    const double root = std::hypot(half, h12);
    const double turn = 0.5 * std::atan2(h12, half);
    const double c = std::cos(turn), s = std::sin(turn);
    const double one = -(c * g1 + s * g2) / size(middle + root, 1);
    const double other = -(c * g2 - s * g1) / size(middle - root, 1);
    return (c * one - s * other) * first + (s * one + c * other) * second;
  }
  [[nodiscard]] double step_u() const { return -gu / size(huu, e); }
  [[nodiscard]] double step_v() const { return -gv / size(hvv, g); }

 private:
  // The way across the longer tangent that has such parameters but for its length, by the squares
  // of both tangents. Tangents that are one count as if they were not quite.
  [[nodiscard]] glm::dvec2 across(const glm::dvec2& way, double longer, double shorter) const {
    const double width = std::max(area / std::sqrt(longer), 1e-10 * std::sqrt(shorter));
    return width > 0 ? way / width : glm::dvec2(0.0);
  }
  [[nodiscard]] double bend(const glm::dvec2& a, const glm::dvec2& b) const {
    return a.x * (huu * b.x + huv * b.y) + a.y * (huv * b.x + hvv * b.y);
  }
  // `square`: of the way that the parameter makes.
  static double size(double second, double square) {
    return std::max(std::abs(second), kLeastBend * square);
  }
};

}  // namespace

// A rectangle of a piece's square, and the distance over it. Where an end is fixed both are one.
struct NearestSearch::Region {
  DistanceNet net;
  double made_of;  // the largest square distance when the net was made
  // How far a place moves at most from end to end along u and v.
  std::array<double, 2> extent;
  std::array<double, 2> low{0, 0}, high{1, 1};

  Region(const BezierNet& of, const glm::dvec3& point)
      : net(of, point),
        made_of(net.largest()),
        extent{largest_speed(of, false), largest_speed(of, true)} {}

  [[nodiscard]] bool is_fixed(bool along_v) const { return low[along_v] == high[along_v]; }
  [[nodiscard]] double least() const { return net.least() - kBoundRounding * made_of; }
  [[nodiscard]] bool is_blocked(bool along_v, double t, double gradient) const {
    return (t <= low[along_v] && gradient >= 0) || (t >= high[along_v] && gradient <= 0);
  }
  [[nodiscard]] bool is_left(bool along_v, double t, double step) const {
    return (t <= low[along_v] && step < 0) || (t >= high[along_v] && step > 0);
  }
  [[nodiscard]] bool is_at_border(double u, double v) const {
    return u <= low[0] || u >= high[0] || v <= low[1] || v >= high[1];
  }
  // Where a descent begins.
  [[nodiscard]] glm::dvec2 start() const {
    const auto share = net.place_of_least();
    return {low[0] + share[0] * (high[0] - low[0]), low[1] + share[1] * (high[1] - low[1])};
  }
  // Within it, and on its border where it is as good as there.
  [[nodiscard]] double inside(bool along_v, double t) const {
    const double margin = kBorder * (high[along_v] - low[along_v]);
    if (t < low[along_v] + margin) return low[along_v];
    return t > high[along_v] - margin ? high[along_v] : t;
  }
  [[nodiscard]] BezierNet part_of(const BezierNet& piece) const {
    return net_between(net_between(piece, true, low[1], high[1]), false, low[0], high[0]);
  }
  // By half its size on all sides. The net stays what it was.
  [[nodiscard]] Region continued() const {
    Region wide = *this;
    for (std::size_t d = 0; d < 2; ++d) {
      const double more = 0.5 * (high[d] - low[d]);
      wide.low[d] -= more;
      wide.high[d] += more;
    }
    return wide;
  }
  // Of the same bounds, nearer to what they are now.
  void make_again(const BezierNet& of_piece, const glm::dvec3& point) {
    const Region made(part_of(of_piece), point);
    net = made.net;
    made_of = made.made_of;
    extent = made.extent;
  }
  [[nodiscard]] Region half(bool along_v, bool upper) const {
    Region part = *this;
    part.net = net.half(along_v, upper);
    part.extent[along_v] *= 0.5;
    (upper ? part.low : part.high)[along_v] = 0.5 * (low[along_v] + high[along_v]);
    return part;
  }
  void fix(bool along_v, bool upper) {
    net = net.border(along_v, upper);
    extent[along_v] = 0;
    (upper ? low : high)[along_v] = (upper ? high : low)[along_v];
  }
};

// Where a descent in a region ends, and whether the distance falls no further there, but for what
// is negligible.
struct NearestSearch::Lowest {
  double u, v, value;
  bool is_lowest;
};

// Newton's method in a region: steps end at its borders, and go along them where the distance falls
// outwards. Nothing of the surface bends abruptly on the way.
NearestSearch::Lowest NearestSearch::lowest_in(const PatchPiece& piece, const Region& region,
                                               const glm::dvec2& start, const glm::dvec3& point) {
  double u = start.x, v = start.y;
  Descent here(piece.at(u, v), point);
  bool is_lowest = false;
  for (int step = 0; step < kMostDescents; ++step) {
    const bool fixed_u = region.is_blocked(false, u, here.gu);
    const bool fixed_v = region.is_blocked(true, v, here.gv);
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
    const bool leaves_u = region.is_left(false, u, du), leaves_v = region.is_left(true, v, dv);
    if (leaves_u) du = 0;
    if (leaves_v) dv = 0;
    if (leaves_u && dv != 0) dv = here.step_v();
    if (leaves_v && du != 0) du = here.step_u();
    is_lowest = -(here.gu * du + here.gv * dv) <= negligible(here.value);
    if (!(std::abs(du) + std::abs(dv) > kSmallStep)) break;  // NaN too: no tangents
    bool falls = false;
    for (double share = 1; share > kSmallestShare && !falls; share *= 0.5) {
      const double next_u = region.inside(false, u + share * du);
      const double next_v = region.inside(true, v + share * dv);
      const Descent next(piece.at(next_u, next_v), point);
      if (!(next.value < here.value)) continue;
      u = next_u;
      v = next_v;
      here = next;
      falls = true;
    }
    if (!falls) break;
  }
  return {u, v, here.value, is_lowest};
}

bool NearestSearch::descend(const PatchPiece& piece, const Region& region,
                            const glm::dvec3& point) {
  const Lowest lowest = lowest_in(piece, region, region.start(), point);
  take(lowest.value, piece.frame.at(lowest.u, lowest.v));
  return lowest.is_lowest;
}

// Whether a region is done with as a sheet: too far, or it has one nearest place at most, which is
// found, or lies beyond the piece: then the region's own is on the piece's border, or beyond a
// border within the piece are nearer ones.
bool NearestSearch::search_sheet(const PatchPiece& piece, const Region& region,
                                 const glm::dvec3& point) {
  SheetBound sheet(region.part_of(piece.net), point);
  if (is_beyond(sheet.least_distance())) return true;
  if (!sheet.has_one_nearest()) return false;
  const auto from_point = [&](const Lowest& lowest) {
    PatchPoint place = piece.at(lowest.u, lowest.v);
    place.position -= point;
    return place;
  };
  const Region wide = region.continued();
  const Lowest beyond = lowest_in(piece, wide, region.start(), point);
  if (!beyond.is_lowest || wide.is_at_border(beyond.u, beyond.v) ||
      !sheet.is_over_convex_part(from_point(beyond).position)) {
    const Lowest lowest = lowest_in(piece, region, region.start(), point);
    take(lowest.value, piece.frame.at(lowest.u, lowest.v));
    return wanted_ < 0 || sheet.least_square(from_point(lowest)) >= wanted_;
  }
  const auto is_in = [](double t) { return t >= 0 && t <= 1; };
  if (is_in(beyond.u) && is_in(beyond.v)) {
    take(beyond.value, piece.frame.at(beyond.u, beyond.v));
    return true;
  }
  for (const bool along_v : {false, true}) {
    for (const bool upper : {false, true}) {
      if ((upper ? region.high : region.low)[along_v] != (upper ? 1 : 0)) continue;
      Region border = region;
      border.fix(along_v, upper);
      search_region(piece, border, point);
    }
  }
  return true;
}

void NearestSearch::take(double square_distance, const glm::dvec2& place) {
  if (!(square_distance < best_.square_distance)) return;
  best_ = {corner_, place.x, place.y, square_distance};
  want();
}

void NearestSearch::want() {
  const double nearer = (1 - kRelative) * std::sqrt(best_.square_distance) - absolute_;
  wanted_ = nearer > 0 ? nearer * nearer : -1;
}

// Boxes and planes are exact but for rounding.
bool NearestSearch::is_near(const PatchBox& box, const glm::dvec3& point) const {
  return square_distance(box, point) <= wanted_ * (1 + 1e-12);
}

// Of bounds that are exact but for rounding.
bool NearestSearch::is_beyond(double distance) const {
  const double least = distance - 1e-15;
  return least > 0 && least * least > wanted_ * (1 + 1e-12);
}

// A piece that is not done with by its bounds or one descent waits until the others have been
// looked at: what is found there by then mostly tells that it has nothing nearer.
void NearestSearch::search_piece(const PatchPiece& piece, const glm::dvec3& point) {
  if (wanted_ < 0 || is_beyond(piece.least_distance(point)) ||
      is_beyond(SheetBound(piece.net, point).least_distance()))
    return;
  ++region_count_;
  const Region region(piece.net, point);
  if (is_far(region)) return;
  if (descend(piece, region, point) && region.net.is_convex()) return;
  if (!is_far(region)) split_later_.push_back({corner_, piece, point});
}

void NearestSearch::search_waiting_pieces() {
  for (const WaitingPiece& waiting : split_later_) {
    corner_ = waiting.corner;
    search_region(waiting.piece, Region(waiting.piece.net, waiting.point), waiting.point);
  }
  split_later_.clear();
}

// Bounds of what lies at the point itself may be below nothing.
bool NearestSearch::is_far(const Region& region) const {
  return wanted_ < 0 || region.least() >= wanted_;
}

// A region has nothing nearer, or is left for its border, or is convex so that a descent ends at
// its nearest place; else its halves are searched, the nearer one first.
void NearestSearch::search_region(const PatchPiece& piece, Region region, const glm::dvec3& point) {
  if (is_far(region)) return;
  if (++region_count_ % kPatience == 0) {
    absolute_ *= 10;
    want();
  }
  if (region.net.largest() < kWorn * region.made_of) {
    region.make_again(piece.net, point);
    if (is_far(region)) return;
  }
  for (const bool along_v : {false, true}) {
    const int slope = region.is_fixed(along_v) ? 0 : region.net.slope(along_v);
    if (slope == 0) continue;
    const bool upper = slope < 0;
    const double end = upper ? region.high[along_v] : region.low[along_v];
    if (end > 0 && end < 1) return;  // the region beyond has it, and nearer places
    region.fix(along_v, upper);
  }
  const bool is_line = region.is_fixed(false) || region.is_fixed(true);
  const bool is_convex = is_line ? (region.is_fixed(false) || region.net.is_convex_along(false)) &&
                                       (region.is_fixed(true) || region.net.is_convex_along(true))
                                 : region.net.is_convex();
  const bool is_nearer = region.net.least_at_corners() < best_.square_distance;
  if ((is_convex || is_nearer) && descend(piece, region, point) && is_convex) return;
  if (is_far(region) || (!is_line && search_sheet(piece, region, point))) return;
  if (!(region.extent[0] + region.extent[1] > kAbsolute)) {  // NaN too
    descend(piece, region, point);
    return;
  }
  // Not along what has no length: needles would be cut without end.
  const bool along_v = region.extent[0] <= 0.5 * kAbsolute ||
                       (region.extent[1] > 0.5 * kAbsolute && region.net.bends_more_along_v());
  Region near = region.half(along_v, false), far = region.half(along_v, true);
  if (far.net.least() < near.net.least()) std::swap(near, far);
  search_region(piece, near, point);
  search_region(piece, far, point);
}

// Quarter by quarter, the nearest one first, those that come near enough. Where a quarter is no
// polynomial, each polynomial of it.
void NearestSearch::search_corner(std::int32_t corner, const glm::dvec3& target) {
  corner_ = corner;
  ++corner_count_;
  PatchPieces& pieces = kept_[static_cast<std::size_t>(corner) % kept_.size()];
  pieces.move_to(corner);
  struct Start {
    double square_distance;
    std::size_t quarter;
  };
  std::array<Start, 4> starts;
  const glm::dvec3 point = target - pieces.own();
  for (std::size_t q = 0; q < 4; ++q) starts[q] = {square_distance(pieces.box(q), point), q};
  std::ranges::sort(starts, {}, &Start::square_distance);
  for (const auto& [_, q] : starts) {
    if (!is_near(pieces.box(q), point)) break;
    if (const PatchPiece* const piece = pieces.piece(q)) {
      search_piece(*piece, point);
    } else {
      const glm::dvec3 off = pieces.vertex(q) - point;
      take(glm::dot(off, off), PatchPieces::vertex_frame(q).at(0, 0));
      for (std::size_t halving = 0; const PatchRing* const ring = pieces.ring(q, halving);
           ++halving) {
        for (std::size_t k = 0; k < ring->pieces.size(); ++k)
          if (is_near(ring->boxes[k], point)) search_piece(ring->pieces[k], point);
        if (!is_near(ring->rest, point)) break;
      }
    }
  }
}

NearestPlace NearestSearch::run(const glm::dvec3& point) {
  best_ = {.corner = -1, .square_distance = std::numeric_limits<double>::infinity()};
  absolute_ = kAbsolute;
  corner_count_ = region_count_ = 0;
  want();
  const auto& nodes = tree_.nodes();
  const glm::dvec3 turned = tree_.turned(point);
  waiting_.assign(1, {0, square_distance(nodes[0].box, turned)});
  while (!waiting_.empty()) {
    const Waiting next = waiting_.back();
    waiting_.pop_back();
    if (next.square_distance >= wanted_) continue;
    const CornerTree::Node& node = nodes[next.node];
    if (node.count > 0) {
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (square_distance(tree_.boxes()[at], turned) < wanted_)
          search_corner(tree_.corners()[at], point);
      }
      continue;
    }
    Waiting left{next.node + 1, 0}, right{node.right, 0};
    left.square_distance = square_distance(nodes[left.node].box, turned);
    right.square_distance = square_distance(nodes[right.node].box, turned);
    // The nearer one is looked at first.
    if (left.square_distance < right.square_distance) std::swap(left, right);
    waiting_.push_back(left);
    waiting_.push_back(right);
  }
  search_waiting_pieces();
  return best_;
}

}  // namespace planish
