#include "planish/queries/surface_queries.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/patches/bezier_net.h"
#include "planish/patches/patch_form.h"
#include "planish/queries/closest_point.h"

namespace planish {
namespace {

constexpr std::int32_t kLeaf = 2;
constexpr std::size_t kBoxGrain = 512;
constexpr std::int32_t kSerial = 4096;  // corners below which a subtree is made by one thread

// Nodes of a subtree over so many corners.
std::int32_t node_count(std::int32_t corners) {
  if (corners <= kLeaf) return 1;
  return 1 + node_count(corners / 2) + node_count(corners - corners / 2);
}

float below(double value) {
  const auto rounded = static_cast<float>(value);
  return rounded > value ? std::nextafter(rounded, -std::numeric_limits<float>::infinity())
                         : rounded;
}

float above(double value) { return -below(-value); }

CornerBox outward(const PatchBox& box, const glm::dvec3& origin) {
  // Sums of weights are 1 to rounding, which this is far above.
  constexpr double kRounding = 1e-14;
  CornerBox result;
  for (int d = 0; d < 3; ++d) {
    result.low[d] = below(origin[d] + box.low[d] - kRounding);
    result.high[d] = above(origin[d] + box.high[d] + kRounding);
  }
  return result;
}

CornerBox united(const CornerBox& a, const CornerBox& b) {
  return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

// By how much less area boxes along other axes must have.
constexpr double kWorthTurning = 0.5;

// The chance of a ray to meet boxes is as their areas.
double area_of(std::span<const CornerBox> boxes) {
  double area = 0;
  for (const CornerBox& box : boxes) {
    const glm::dvec3 size = glm::dvec3(box.high) - glm::dvec3(box.low);
    area += size.x * size.y + size.y * size.z + size.z * size.x;
  }
  return area;
}

// Principal axes of the boxes' middles where these reach much less far along one than along
// another.
std::optional<glm::dmat3> axes_of_thin(std::span<const CornerBox> boxes) {
  constexpr double kThin = 1.0 / 16;
  const auto middle = [](const CornerBox& box) {
    return 0.5 * (glm::dvec3(box.low) + glm::dvec3(box.high));
  };
  const double count = static_cast<double>(boxes.size());
  glm::dvec3 mean(0.0);
  for (const CornerBox& box : boxes) mean += middle(box) / count;
  glm::dmat3 spread(0.0);
  for (const CornerBox& box : boxes) {
    const glm::dvec3 off = middle(box) - mean;
    spread += glm::outerProduct(off, off) / count;
  }
  const glm::dmat3 axes = eigenvectors(spread);
  const auto [least, most] = std::minmax({spread[0][0], spread[1][1], spread[2][2]});
  if (!(least < kThin * kThin * most)) return std::nullopt;
  return axes;
}

}  // namespace

CornerTree::CornerTree(const LimitSurface& surface) : surface_(surface) {
  const MeshTopology& topology = surface.topology();
  const std::span<const std::uint8_t> hidden = surface.surface().hidden();
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
    if (hidden.empty() || hidden[topology.face_of(c)] == 0) corners_.push_back(c);
  }
  for (const PatchForm* form : surface.forms()) reaches_.add(*form);
  rebuild();
}

void CornerTree::make_boxes(std::span<const std::int32_t> corners,
                            std::span<CornerBox> boxes) const {
  parallel_for(corners.size(), kBoxGrain, [&](std::size_t begin, std::size_t end) {
    LimitSurface::Corner corner(surface_);
    std::vector<glm::dvec3> points;
    for (std::size_t i = begin; i < end; ++i) {
      corner.move_to(corners[i]);
      std::span<const glm::dvec3> given = corner.points();
      if (is_turned_) {
        points.clear();
        for (const glm::dvec3& point : given) points.push_back(turned(point));
        given = points;
      }
      boxes[i] = outward(patch_box(corner.form(), given, reaches_), turned(corner.own()));
    }
  });
}

void CornerTree::rebuild() {
  place_of_corner_.clear();
  std::ranges::sort(corners_);
  if (corners_.empty()) return;
  RawVector<CornerBox> in_order(corners_.size());
  is_turned_ = false;
  make_boxes(corners_, in_order);
  choose_axes(in_order);
  boxes_.resize(static_cast<std::size_t>(surface_.topology().corner_count()));
  for (std::size_t i = 0; i < corners_.size(); ++i)  // by corner while the tree is made
    boxes_[corners_[i]] = in_order[i];
  const auto count = static_cast<std::int32_t>(corners_.size());
  nodes_.resize(static_cast<std::size_t>(node_count(count)));
  build(0, 0, count);
  for (std::size_t i = 0; i < corners_.size(); ++i) in_order[i] = boxes_[corners_[i]];
  boxes_.swap(in_order);
}

void CornerTree::choose_axes(RawVector<CornerBox>& boxes) {
  const auto axes = axes_of_thin(boxes);
  if (!axes) return;
  axes_ = *axes;
  is_turned_ = true;
  RawVector<CornerBox> along(boxes.size());
  make_boxes(corners_, along);
  if (area_of(along) < kWorthTurning * area_of(boxes)) {
    boxes.swap(along);
  } else {
    is_turned_ = false;
  }
}

std::int64_t CornerTree::refit(std::span<const std::int32_t> corners) {
  if (nodes_.empty() || corners.empty()) return 0;
  if (place_of_corner_.empty()) number_places();
  places_.clear();
  for (const std::int32_t corner : corners)
    if (const std::int32_t place = place_of_corner_[corner]; place >= 0) places_.push_back(place);
  std::ranges::sort(places_);
  of_places_.clear();
  for (const std::int32_t place : places_) of_places_.push_back(corners_[place]);
  new_boxes_.resize(places_.size());
  make_boxes(of_places_, new_boxes_);
  for (std::size_t i = 0; i < places_.size(); ++i) boxes_[places_[i]] = new_boxes_[i];
  return refit_node(0, 0, static_cast<std::int32_t>(corners_.size()), places_);
}

void CornerTree::number_places() {
  place_of_corner_.assign(static_cast<std::size_t>(surface_.topology().corner_count()), -1);
  for (std::size_t i = 0; i < corners_.size(); ++i)
    place_of_corner_[corners_[i]] = static_cast<std::int32_t>(i);
}

// The node over corners_[first] to corners_[last - 1], some of which have other boxes.
std::int64_t CornerTree::refit_node(std::int32_t index, std::int32_t first, std::int32_t last,
                                    std::span<const std::int32_t> places) {
  if (places.empty()) return 0;
  Node& node = nodes_[index];
  if (node.count > 0) {
    node.box = boxes_[first];
    for (std::int32_t i = first + 1; i < last; ++i) node.box = united(node.box, boxes_[i]);
    return 1;
  }
  const std::int32_t middle = first + (last - first) / 2;
  const auto split =
      static_cast<std::size_t>(std::ranges::lower_bound(places, middle) - places.begin());
  const std::int64_t count = 1 + refit_node(index + 1, first, middle, places.first(split)) +
                             refit_node(node.right, middle, last, places.subspan(split));
  node.box = united(nodes_[index + 1].box, nodes_[node.right].box);
  return count;
}

void CornerTree::build(std::int32_t index, std::int32_t first, std::int32_t last) {
  check_stop();
  Node& node = nodes_[index];
  node = {};
  const auto box = [&](std::int32_t i) -> const CornerBox& { return boxes_[corners_[i]]; };
  if (last - first <= kLeaf) {
    node.box = box(first);
    for (std::int32_t i = first + 1; i < last; ++i) node.box = united(node.box, box(i));
    node.first = first;
    node.count = last - first;
    return;
  }
  // Middles' extent decides the direction, their median the place: two halves of known size.
  glm::vec3 low(std::numeric_limits<float>::infinity()), high(-low);
  for (std::int32_t i = first; i < last; ++i) {
    const glm::vec3 middle = box(i).low + box(i).high;
    low = glm::min(low, middle);
    high = glm::max(high, middle);
  }
  const glm::vec3 size = high - low;
  const int along = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::int32_t middle = first + (last - first) / 2;
  std::nth_element(corners_.begin() + first, corners_.begin() + middle, corners_.begin() + last,
                   [&](std::int32_t a, std::int32_t b) {
                     const CornerBox& p = boxes_[a];
                     const CornerBox& q = boxes_[b];
                     const float pa = p.low[along] + p.high[along];
                     const float qa = q.low[along] + q.high[along];
                     return pa != qa ? pa < qa : a < b;
                   });
  const std::int32_t left = index + 1, right = left + node_count(middle - first);
  if (last - first > kSerial) {
    parallel_each(2, 1, [&](std::size_t half) {
      half == 0 ? build(left, first, middle) : build(right, middle, last);
    });
  } else {
    build(left, first, middle);
    build(right, middle, last);
  }
  node.right = right;
  node.box = united(nodes_[left].box, nodes_[right].box);
}

namespace {

// Where a ray meets a surface, in unit coordinates.
struct RayPlace {
  std::int32_t corner = -1;
  double u = 0, v = 0;
  double t = 0;
  glm::dvec3 normal{};  // not of unit length
  bool is_tangent = false;
  bool is_singular = false;  // at a vertex or face centre without a polynomial
};

enum class RayAnswer {
  All,    // by ascending t; what several patches share once
  First,  // the smallest t
  Any,    // one, whichever is found first
};

// Searches a tree for the places where a ray meets the surface. Patches are split until the ray
// can meet a piece once at most (seen along the ray, no two of its directions are parallel) or
// not at all; then Newton's method. Used again from ray to ray; one a thread.
class RaySearch {
 public:
  explicit RaySearch(const CornerTree& tree) : tree_(tree), corner_(tree.surface()) {}

  // In unit coordinates, the direction of unit length.
  [[nodiscard]] const std::vector<RayPlace>& run(const glm::dvec3& origin,
                                                 const glm::dvec3& direction, double t_min,
                                                 double t_max, RayAnswer wanted);

 private:
  [[nodiscard]] bool meets(const CornerBox& box) const;
  [[nodiscard]] bool can_meet(std::span<const glm::dvec3> points, double reach) const;
  void search_corner(std::int32_t corner);
  void search_form(const PatchForm& form, std::span<const glm::dvec3> points,
                   const PatchFrame& frame);
  // Nets are as the ray sees them: two directions across it, and t.
  void search_net(const BezierNet& net, const PatchFrame& frame);
  bool solve(const BezierNet& net, const PatchFrame& frame);
  void add(const PatchFrame& frame, const glm::dvec2& local, bool is_tangent, bool is_singular);
  [[nodiscard]] bool is_done() const { return wanted_ == RayAnswer::Any && !places_.empty(); }

  const CornerTree& tree_;
  LimitSurface::Corner corner_;
  glm::dvec3 origin_{}, direction_{}, right_{}, up_{};
  glm::dvec3 turned_origin_{}, turned_direction_{};  // by the tree's axes
  double t_min_ = 0, t_max_ = 0;
  RayAnswer wanted_ = RayAnswer::All;
  std::int32_t corner_number_ = -1;
  int pieces_ = 0;  // of the corner, so far
  std::vector<RayPlace> places_;
};

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
  const double size = portable::hypot(along.x, along.y);
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
  std::ranges::sort(places_, {},
                    [](const RayPlace& place) { return std::pair(place.t, place.corner); });
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

constexpr std::size_t kQuestionGrain = 64;

bool is_finite(const glm::dvec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

void require_finite(const glm::dvec3& point, std::size_t index) {
  if (is_finite(point)) return;
  throw Error(ErrorCode::InvalidArgument, formatted("point {} is not finite", index));
}

// From here on the surface is one point, in unit coordinates.
constexpr double kFarthest = 1e100;

// In unit coordinates. From so far that squares are too large for double, the surface is one point;
// of a small one the coordinates of such a place are themselves too large.
glm::dvec3 nearby(const glm::dvec3& point, const Placement& placement) {
  const glm::dvec3 unit = placement.to_unit(point);
  const double far = safe_length(unit);
  if (far <= kFarthest) return unit;
  if (std::isfinite(far)) return unit * (kFarthest / far);
  constexpr double kSmall = 0x1p-600;  // the centre does not count from there
  const glm::dvec3 small = point * kSmall;
  return small * (kFarthest / safe_length(small));
}

void require_room(std::string_view name, std::size_t points, std::size_t answers) {
  if (points == answers) return;
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: there are {} points, and room for {} answers", name, points, answers));
}

// Calls answer(search, i) for each of the points.
template <class Answer>
void ask_each(const CornerTree& tree, std::size_t kept_corners, std::span<const glm::dvec3> points,
              const Answer& answer) {
  parallel_for(points.size(), kQuestionGrain, [&](std::size_t begin, std::size_t end) {
    NearestSearch search(tree, kept_corners);
    for (std::size_t i = begin; i < end; ++i) {
      require_finite(points[i], i);
      answer(search, i);
    }
  });
}

ClosestPoint closest_point(NearestSearch& search, const LimitSurface& surface,
                           const glm::dvec3& point) {
  const NearestPlace place = search.run(nearby(point, surface.surface().placement()));
  ClosestPoint result;
  result.at = surface_parameter(surface.topology(), place.corner, place.u, place.v);
  const SurfacePoint on = surface.evaluate(result.at);
  result.position = on.position;
  result.normal = on.normal;
  result.distance = safe_length(point - on.position);
  return result;
}

struct UnitRay {
  glm::dvec3 origin, direction;
  double t_min, t_max, length;  // length: of one t
};

UnitRay unit_ray(const SurfaceRay& ray, const Placement& placement) {
  const double length = safe_length(ray.direction);
  if (!is_finite(ray.origin) || !std::isfinite(length) || !(length > 0)) {
    throw Error(ErrorCode::InvalidArgument,
                "the ray has no finite origin or no direction of a length above 0");
  }
  const double scale = length / placement.diagonal;
  return {placement.to_unit(ray.origin), ray.direction / length, ray.t_min * scale,
          ray.t_max * scale, scale};
}

std::vector<SurfaceHit> hits_of(const CornerTree& tree, const SurfaceRay& ray, RayAnswer wanted) {
  const LimitSurface& surface = tree.surface();
  const UnitRay unit = unit_ray(ray, surface.surface().placement());
  RaySearch search(tree);
  std::vector<SurfaceHit> hits;
  for (const RayPlace& place :
       search.run(unit.origin, unit.direction, unit.t_min, unit.t_max, wanted)) {
    SurfaceHit hit;
    hit.at = surface_parameter(surface.topology(), place.corner, place.u, place.v);
    const SurfacePoint on = surface.evaluate(hit.at);
    hit.position = on.position;
    hit.normal = on.normal;
    hit.t = place.t / unit.length;
    hit.is_tangent = place.is_tangent;
    hits.push_back(hit);
  }
  return hits;
}

}  // namespace

SurfaceQueries::SurfaceQueries(const LimitSurface& surface) : tree_(surface) {
  if (tree_.nodes().empty())
    throw Error(ErrorCode::UnusableMesh, "the surface has no faces: all of the mesh's are holes");
}

ClosestPoint SurfaceQueries::closest(const glm::dvec3& point) const {
  require_finite(point, 0);
  NearestSearch search(tree_);
  return closest_point(search, surface(), point);
}

void SurfaceQueries::closest(std::span<const glm::dvec3> points,
                             std::span<ClosestPoint> result) const {
  require_room("closest", points.size(), result.size());
  ask_each(tree_, 1, points, [&](NearestSearch& search, std::size_t i) {
    result[i] = closest_point(search, surface(), points[i]);
  });
}

void SurfaceQueries::distances(std::span<const glm::dvec3> points, std::span<double> result) const {
  require_room("distances", points.size(), result.size());
  const Placement& placement = surface().surface().placement();
  ask_each(tree_, NearestSearch::kManyCorners, points, [&](NearestSearch& search, std::size_t i) {
    const glm::dvec3 unit = placement.to_unit(points[i]);
    result[i] = safe_length(unit) <= kFarthest
                    ? placement.diagonal * std::sqrt(search.run(unit).square_distance)
                    : closest_point(search, surface(), points[i]).distance;
  });
}

// By parity of hits, each way by other directions where one touches the surface.
bool SurfaceQueries::is_inside(const glm::dvec3& point) const {
  constexpr int kTries = 8;
  glm::dvec3 direction(0.8191, 0.4233, 0.3874);
  for (int i = 0; i < kTries; ++i) {
    const auto hits = hits_of(tree_, {point, direction}, RayAnswer::All);
    bool is_clear = true;
    for (const SurfaceHit& hit : hits) is_clear &= !hit.is_tangent;
    if (is_clear) return hits.size() % 2 == 1;
    direction = glm::normalize(glm::dvec3(direction.y + 0.1, -direction.z, direction.x - 0.2));
  }
  return false;
}

double SurfaceQueries::signed_distance(const glm::dvec3& point) const {
  const ClosestPoint nearest = closest(point);
  // At a sharp edge the nearest side's own normal can point the wrong way.
  const DooSabinSurface& surface = this->surface().surface();
  const bool is_smooth = surface.patches().features().sharp_edge_count == 0;
  const bool inside =
      is_smooth ? glm::dot(point - nearest.position, nearest.normal) < 0 : is_inside(point);
  return inside ? -nearest.distance : nearest.distance;
}

std::optional<SurfaceHit> SurfaceQueries::first_hit(const SurfaceRay& ray) const {
  const auto hits = hits_of(tree_, ray, RayAnswer::First);
  if (hits.empty()) return std::nullopt;
  return hits.front();
}

std::vector<SurfaceHit> SurfaceQueries::all_hits(const SurfaceRay& ray) const {
  return hits_of(tree_, ray, RayAnswer::All);
}

bool SurfaceQueries::is_occluded(const SurfaceRay& ray) const {
  return !hits_of(tree_, ray, RayAnswer::Any).empty();
}

}  // namespace planish
