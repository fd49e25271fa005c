#include "planish/analytic/settle_surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <map>
#include <numeric>

#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

constexpr std::int32_t kNone = -1;

// How exactly the vertices of a region tell its surface.
struct Certainty {
  double turn = 0, shift = 0, along = 0, radius = 0, minor = 0;
};

constexpr double kLeastError = 2e-7;  // of vertices, of the diagonal: float32 has no more
constexpr double kTimes = 5;          // so many deviations are chance

// Whether its vertices tell surfaces worse than a mesh of float32 can say them.
bool is_noisy(const AnalyticRegion& region) { return region.error > kTimes * kTimes * kLeastError; }

Certainty certainty_of(const AnalyticSurface& surface, std::span<const glm::dvec3> points,
                       double error) {
  const auto changes = changes_of(surface.kind);
  const std::size_t n = changes.size();
  std::vector<double> matrix(n * n);
  for (const glm::dvec3& p : points) {
    const SurfaceChange g = distance_gradient(surface, p);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) matrix[n * i + j] += g[changes[i]] * g[changes[j]];
  }
  SurfaceChange deviation;
  deviation.fill(1);
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<double> copy = matrix, unit(n);
    unit[i] = 1;
    if (solve_cholesky(copy, unit) && unit[i] > 0)
      deviation[changes[i]] = std::max(error, kLeastError) * std::sqrt(unit[i]);
  }
  return {std::max(deviation[0], deviation[1]), std::max(deviation[2], deviation[3]), deviation[4],
          deviation[5], deviation[6]};
}

// Numbers that several regions share.
struct Direction {
  glm::dvec3 axis{};
  double deviation = 0;
  std::int32_t first = kNone;  // of its two unknowns; kNone: it stays
};
struct Anchor {
  glm::dvec3 point{};
  std::int32_t direction = kNone;
  double deviation = 0;
  std::int32_t first = kNone;  // of two unknowns across the direction
};
struct Length {
  double value = 0, deviation = 0;
  std::int32_t unknown = kNone;
};

struct Placed {
  std::int32_t direction = kNone, anchor = kNone, along = kNone, radius = kNone, minor = kNone;
  double sign = 1;  // of the direction
};

class Settler {
 public:
  Settler(std::span<const glm::dvec3> positions, const MeshTopology& topology,
          const RegionBorders& borders, AnalyticRegions& regions)
      : positions_(positions), topology_(topology), borders_(borders), regions_(regions) {
    for (const AnalyticRegion& region : regions_.regions) {
      points_.push_back(points_of(region));
      certainties_.push_back(certainty_of(region.surface, points_.back(), region.error));
    }
  }

  SettledRegions settle() && {
    placed_.resize(regions_.regions.size());
    share_directions();
    share_anchors();
    share_lengths();
    share_places();
    number();
    find_contacts();
    const std::vector<AnalyticRegion> before = regions_.regions;
    put_all();
    find_meetings();
    drop_false_conditions();
    if (unknowns_ > 0 && unknowns_ <= kMostUnknowns) {
      const Unknowns first = unknowns_values();
      improve();
      for (int round = 0; round < kMostRounds && drop_pulling_conditions(before); ++round) {
        take(first);
        put_all();
        improve();
      }
    }
    keep_near(before);
    return {std::move(is_tangent_)};
  }

 private:
  static constexpr std::int32_t kMostUnknowns = 3000;
  static constexpr int kSteps = 8, kMostRounds = 12;

  [[nodiscard]] std::vector<glm::dvec3> points_of(const AnalyticRegion& region) const {
    std::vector<std::int32_t> vertices;
    for (const std::int32_t f : region.faces)
      for (const std::int32_t v : topology_.face(f)) vertices.push_back(v);
    std::ranges::sort(vertices);
    vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
    // Samples that the region does not reach are none of it.
    constexpr double kMost = 4;
    const double most = kMost * std::max(region.error, kLeastError);
    std::vector<glm::dvec3> points;
    for (const std::int32_t v : vertices)
      if (std::abs(signed_distance(region.surface, positions_[v])) <= most)
        points.push_back(positions_[v]);
    return points;
  }
  // Regions, those first whose vertices tell most.
  template <class By>
  [[nodiscard]] std::vector<std::size_t> by_certainty(const By& by) const {
    std::vector<std::size_t> order(regions_.regions.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, std::less<>(), by);
    return order;
  }
  static double tolerance(double a, double b) { return kTimes * portable::hypot(a, b) + 1e-9; }

  void share_directions() {
    for (const glm::dvec3 axis : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)})
      directions_.push_back({axis, 0, kNone});
    constexpr double kMost = 0.3 * kDegree;
    for (const std::size_t r : by_certainty([&](std::size_t i) { return certainties_[i].turn; })) {
      const AnalyticSurface& surface = regions_.regions[r].surface;
      if (surface.kind == AnalyticKind::Sphere) continue;
      std::int32_t found = kNone;
      double nearest = 2;
      for (std::int32_t d = 0; d < std::ssize(directions_); ++d) {
        const double apart = glm::length(glm::cross(surface.axis, directions_[d].axis));
        if (apart < nearest) {
          nearest = apart;
          found = d;
        }
      }
      const double reach =
          std::min(kMost, tolerance(certainties_[r].turn, directions_[found].deviation));
      if (nearest > reach) {
        found = static_cast<std::int32_t>(directions_.size());
        directions_.push_back(
            {square_to_others(surface.axis, certainties_[r].turn), certainties_[r].turn, kFree});
      }
      placed_[r].direction = found;
      placed_[r].sign = glm::dot(surface.axis, directions_[found].axis) < 0 ? -1 : 1;
    }
  }
  // At right angles to directions that it is so nearly.
  [[nodiscard]] glm::dvec3 square_to_others(const glm::dvec3& axis, double deviation) {
    glm::dvec3 result = axis;
    std::vector<glm::dvec3> square;
    const auto index = static_cast<std::int32_t>(directions_.size());
    for (std::int32_t d = 0; d < std::ssize(directions_); ++d) {
      const Direction& other = directions_[d];
      if (std::abs(glm::dot(axis, other.axis)) >
          std::min(0.3 * kDegree, tolerance(deviation, other.deviation)))
        continue;
      right_angles_.push_back({d, index});
      if (square.size() == 2) continue;
      if (square.size() == 1 && glm::length(glm::cross(square[0], other.axis)) < 0.1) continue;
      square.push_back(other.axis);
    }
    if (square.size() == 2) {
      const glm::dvec3 both = glm::normalize(glm::cross(square[0], square[1]));
      result = glm::dot(both, axis) < 0 ? -both : both;
    } else if (square.size() == 1) {
      result = glm::normalize(axis - glm::dot(axis, square[0]) * square[0]);
    }
    return result;
  }

  void share_anchors() {
    for (const std::size_t r : by_certainty([&](std::size_t i) { return certainties_[i].shift; })) {
      const AnalyticSurface& surface = regions_.regions[r].surface;
      if (surface.kind == AnalyticKind::Plane || surface.kind == AnalyticKind::Sphere) continue;
      join_anchor(r, surface.origin, placed_[r].direction, certainties_[r].shift);
    }
    // Centres of spheres beside an axis that passes through them.
    for (const BorderChain& chain : borders_.chains) {
      if (chain.left < 0 || chain.right < 0) continue;
      for (const auto& [ball, other] :
           {std::pair{chain.left, chain.right}, std::pair{chain.right, chain.left}}) {
        if (regions_.regions[ball].surface.kind != AnalyticKind::Sphere ||
            placed_[ball].anchor != kNone || placed_[other].anchor == kNone)
          continue;
        const Anchor& anchor = anchors_[placed_[other].anchor];
        if (apart(anchor, regions_.regions[ball].surface.origin) >
            tolerance(anchor.deviation, certainties_[ball].shift))
          continue;
        placed_[ball].anchor = placed_[other].anchor;
        placed_[ball].direction = anchor.direction;
      }
    }
    for (std::size_t r = 0; r < placed_.size(); ++r) {
      if (placed_[r].anchor != kNone) continue;
      const AnalyticSurface& surface = regions_.regions[r].surface;
      if (surface.kind == AnalyticKind::Sphere) placed_[r].direction = 0;
      placed_[r].anchor = static_cast<std::int32_t>(anchors_.size());
      anchors_.push_back({surface.origin, placed_[r].direction, certainties_[r].shift,
                          surface.kind == AnalyticKind::Sphere ? kFree : kNone});
    }
  }
  static constexpr std::int32_t kFree = -2;  // gets unknowns
  [[nodiscard]] double apart(const Anchor& anchor, const glm::dvec3& point) const {
    const glm::dvec3& axis = directions_[anchor.direction].axis;
    return glm::length(glm::cross(point - anchor.point, axis));
  }
  void join_anchor(std::size_t r, const glm::dvec3& origin, std::int32_t direction,
                   double deviation) {
    for (std::int32_t a = 0; a < std::ssize(anchors_); ++a) {
      if (anchors_[a].direction != direction) continue;
      if (apart(anchors_[a], origin) > std::min(1e-3, tolerance(deviation, anchors_[a].deviation)))
        continue;
      placed_[r].anchor = a;
      return;
    }
    placed_[r].anchor = static_cast<std::int32_t>(anchors_.size());
    anchors_.push_back({origin, direction, deviation, kFree});
  }

  std::int32_t share_length(std::vector<Length>& lengths, double value, double deviation) {
    std::int32_t found = kNone;
    double nearest = 1e-3 * std::abs(value);
    for (std::int32_t l = 0; l < std::ssize(lengths); ++l) {
      const double apart = std::abs(lengths[l].value - value);
      if (apart > std::min(nearest, tolerance(deviation, lengths[l].deviation))) continue;
      nearest = apart;
      found = l;
    }
    if (found != kNone) return found;
    lengths.push_back({value, deviation, kFree});
    return static_cast<std::int32_t>(lengths.size()) - 1;
  }
  void share_lengths() {
    for (const std::size_t r :
         by_certainty([&](std::size_t i) { return certainties_[i].radius; })) {
      const AnalyticSurface& s = regions_.regions[r].surface;
      if (s.kind == AnalyticKind::Plane) continue;
      placed_[r].radius = s.kind == AnalyticKind::Cone
                              ? share_length(slopes_, s.slope, certainties_[r].radius)
                              : share_length(lengths_, s.radius, certainties_[r].radius);
    }
    for (const std::size_t r : by_certainty([&](std::size_t i) { return certainties_[i].minor; })) {
      const AnalyticSurface& s = regions_.regions[r].surface;
      if (s.kind == AnalyticKind::Torus)
        placed_[r].minor = share_length(lengths_, s.minor, certainties_[r].minor);
    }
  }
  // Places along directions: planes in one plane have one.
  void share_places() {
    std::map<std::int32_t, std::vector<std::int32_t>> planes;  // places by direction
    for (const std::size_t r : by_certainty([&](std::size_t i) { return certainties_[i].along; })) {
      const AnalyticSurface& s = regions_.regions[r].surface;
      if (s.kind == AnalyticKind::Cylinder) continue;
      const Anchor& anchor = anchors_[placed_[r].anchor];
      const glm::dvec3& axis = directions_[anchor.direction].axis;
      if (s.kind == AnalyticKind::Plane) {
        // Of its middle from the origin, along the direction that is shared.
        const double place = glm::dot(s.origin, axis);
        std::int32_t found = kNone;
        for (const std::int32_t p : planes[placed_[r].direction])
          if (std::abs(places_[p].value - place) <=
              std::min(1e-4, tolerance(certainties_[r].along, places_[p].deviation)))
            found = p;
        if (found == kNone) {
          found = add_place(place, certainties_[r].along);
          planes[placed_[r].direction].push_back(found);
        }
        placed_[r].along = found;
        anchors_[placed_[r].anchor].point = s.origin - place * axis;
        continue;
      }
      placed_[r].along = add_place(glm::dot(s.origin - anchor.point, axis), certainties_[r].along);
    }
  }
  std::int32_t add_place(double value, double deviation) {
    places_.push_back({value, deviation, kFree});
    return static_cast<std::int32_t>(places_.size()) - 1;
  }

  void number() {
    const auto give = [&](std::int32_t& first, std::int32_t count) {
      if (first != kFree) return;
      first = unknowns_;
      unknowns_ += count;
    };
    for (Direction& direction : directions_) give(direction.first, 2);
    for (Anchor& anchor : anchors_) give(anchor.first, 2);
    for (auto* lengths : {&lengths_, &slopes_, &places_})
      for (Length& length : *lengths) give(length.unknown, 1);
  }

  void put(std::size_t r) {
    AnalyticSurface& s = regions_.regions[r].surface;
    const Placed& at = placed_[r];
    const glm::dvec3 axis = directions_[at.direction].axis;
    if (s.kind != AnalyticKind::Sphere) s.axis = at.sign * axis;
    s.origin = anchors_[at.anchor].point;
    if (at.along != kNone) s.origin += places_[at.along].value * axis;
    if (at.radius != kNone) {
      if (s.kind == AnalyticKind::Cone)
        s.slope = slopes_[at.radius].value;
      else
        s.radius = lengths_[at.radius].value;
    }
    if (at.minor != kNone) s.minor = lengths_[at.minor].value;
  }
  void put_all() {
    for (std::size_t r = 0; r < placed_.size(); ++r) put(r);
  }

  // Of the distance of a point from a region's surface, by the unknowns.
  struct Row {
    std::array<std::int32_t, 7> unknown{};
    std::array<double, 7> value{};
    std::size_t count = 0;

    void add(std::int32_t u, double v) {
      if (u < 0) return;
      unknown[count] = u;
      value[count++] = v;
    }
  };
  // Rows of several regions, which may share unknowns, added up.
  struct RowSum {
    std::vector<std::int32_t> unknowns;
    std::vector<double> values;

    void add(const Row& row, double factor) {
      for (std::size_t i = 0; i < row.count; ++i) {
        const auto found = std::ranges::find(unknowns, row.unknown[i]);
        if (found == unknowns.end()) {
          unknowns.push_back(row.unknown[i]);
          values.push_back(factor * row.value[i]);
        } else {
          values[static_cast<std::size_t>(found - unknowns.begin())] += factor * row.value[i];
        }
      }
    }
  };
  [[nodiscard]] Row row_of(std::size_t r, const glm::dvec3& p) const {
    const AnalyticSurface& s = regions_.regions[r].surface;
    const Placed& at = placed_[r];
    const Direction& direction = directions_[at.direction];
    const Anchor& anchor = anchors_[at.anchor];
    const SurfaceChange gradient = distance_gradient(s, p);
    const glm::dvec3 normal = normal_at(s, p);
    const AxisFrame frame(direction.axis);
    Row row;
    // A sphere turns with the axis that its centre lies on, a plane about its anchor.
    const glm::dvec3 turned = glm::cross(p - anchor.point, normal);
    if (direction.first >= 0) {
      row.add(direction.first, -glm::dot(frame.x, turned));
      row.add(direction.first + 1, -glm::dot(frame.y, turned));
    }
    if (anchor.first >= 0) {
      row.add(anchor.first, -glm::dot(frame.x, normal));
      row.add(anchor.first + 1, -glm::dot(frame.y, normal));
    }
    if (at.along != kNone) row.add(places_[at.along].unknown, -glm::dot(direction.axis, normal));
    if (at.radius != kNone)
      row.add((s.kind == AnalyticKind::Cone ? slopes_ : lengths_)[at.radius].unknown, gradient[5]);
    if (at.minor != kNone) row.add(lengths_[at.minor].unknown, gradient[6]);
    return row;
  }

  // Chains along which both surfaces have one tangent plane.
  void find_contacts() {
    is_tangent_.assign(borders_.chains.size(), 0);
    constexpr double kTouch = 0.5 * kDegree;
    for (std::size_t c = 0; c < borders_.chains.size(); ++c) {
      const BorderChain& chain = borders_.chains[c];
      if (chain.left < 0 || chain.right < 0) continue;
      double most = 0;
      for (const std::int32_t v : chain.vertices) {
        const glm::dvec3& p = positions_[v];
        most = std::max(most, angle_between(regions_.regions[chain.left].normal_at(p),
                                            regions_.regions[chain.right].normal_at(p)));
      }
      const double told =
          kTouch + std::min(kTimes * (doubt(chain.left) + doubt(chain.right)), 2 * kDegree);
      if (most > told && !touch_beside(chain, told)) continue;
      is_tangent_[c] = 1;
      contacts_.push_back(c);
    }
  }
  // A place of a chain, and the plane across the chain there: surfaces that do not agree yet touch
  // at one point of all of it.
  [[nodiscard]] AnalyticSurface across_chain(const BorderChain& chain, double place) const {
    const std::size_t last = chain.vertices.size() - 1;
    const double at = place * static_cast<double>(last);
    const auto before = static_cast<std::size_t>(at);
    const auto position = [&](std::size_t i) { return positions_[chain.vertices[i]]; };
    const double part = at - static_cast<double>(before);
    const glm::dvec3 near = (1 - part) * position(before) + part * position(before + 1);
    // Noise makes single edges go across.
    const std::size_t more = is_noisy(chain) ? 1 + last / 16 : 0;
    const glm::dvec3 from = position(before < more ? 0 : before - more),
                     to = position(std::min(before + 1 + more, last));
    return {.origin = near, .axis = unit_or_zero(to - from)};
  }
  [[nodiscard]] bool is_noisy(const BorderChain& chain) const {
    return planish::is_noisy(regions_.regions[chain.left]) ||
           planish::is_noisy(regions_.regions[chain.right]);
  }
  // Not at a chain's ends, where a third surface may touch both and leave their contact open.
  static constexpr std::array<double, 3> kContactPlaces{0.2, 0.5, 0.8};

  // Whether they do where they are nearest to doing so, beside the chain: noise moves faces from
  // one side of a contact to the other.
  [[nodiscard]] bool touch_beside(const BorderChain& chain, double told) const {
    const AnalyticRegion &first = regions_.regions[chain.left],
                         &second = regions_.regions[chain.right];
    if (!is_noisy(chain)) return false;
    const double noise = std::max(first.error, second.error);
    const BorderSides sides{{&first.surface, first.side()}, {&second.surface, second.side()}, true};
    constexpr double kBeside = 0.02;  // of the diagonal
    for (const double place : kContactPlaces) {
      const AnalyticSurface across = across_chain(chain, place);
      double reach = 0;
      const glm::dvec3 p = sides.point(across.origin, reach, &across);
      if (!(reach <= noise) || glm::length(p - across.origin) > kBeside ||
          angle_between(first.normal_at(p), second.normal_at(p)) > told)
        return false;
    }
    return true;
  }
  [[nodiscard]] double doubt(std::int32_t region) const {
    const AnalyticSurface& s = regions_.regions[region].surface;
    if (s.kind == AnalyticKind::Plane) return certainties_[region].turn;
    const double size = s.kind == AnalyticKind::Torus ? s.minor : s.radius;
    return size > 0 ? std::min(1.0, certainties_[region].shift / size) : 0;
  }
  class Normal {
   public:
    explicit Normal(std::int32_t unknowns)
        : count_(unknowns), matrix_(count_ * count_), right_(count_) {}
    void add(std::span<const std::int32_t> unknowns, std::span<const double> values,
             double residual, double weight) {
      squares_ += weight * residual * residual;
      for (std::size_t i = 0; i < unknowns.size(); ++i) {
        right_[unknowns[i]] -= weight * values[i] * residual;
        for (std::size_t j = 0; j < unknowns.size(); ++j)
          matrix_[count_ * unknowns[i] + unknowns[j]] += weight * values[i] * values[j];
      }
    }
    void add(const Row& row, double residual, double weight) {
      add(std::span(row.unknown).first(row.count), std::span(row.value).first(row.count), residual,
          weight);
    }
    void add(const RowSum& sum, double residual, double weight) {
      add(sum.unknowns, sum.values, residual, weight);
    }
    [[nodiscard]] double squares() const { return squares_; }
    [[nodiscard]] bool solve(double damping) {
      double mean = 0;
      for (std::size_t i = 0; i < count_; ++i) mean += matrix_[count_ * i + i] / double(count_);
      for (std::size_t i = 0; i < count_; ++i)
        matrix_[count_ * i + i] += damping * matrix_[count_ * i + i] + 1e-16 * mean;
      return solve_cholesky(matrix_, right_);
    }
    [[nodiscard]] const std::vector<double>& solution() const { return right_; }

   private:
    std::size_t count_;
    std::vector<double> matrix_, right_;
    double squares_ = 0;
  };

  // Gauss and Newton's steps, damped where conditions that noise has made of chance disagree.
  void improve() {
    constexpr double kFirstDamping = 1e-11, kMostDamping = 1e3, kMore = 1e3;
    double damping = kFirstDamping;
    Normal normal = equations();
    for (int steps = 0; steps < kSteps && damping <= kMostDamping;) {
      const Unknowns before = unknowns_values();
      Normal solved = normal;
      double largest = 0;
      if (solved.solve(damping)) {
        step(solved.solution());
        put_all();
        for (const double x : solved.solution()) largest = std::max(largest, std::abs(x));
        if (!(largest > 1e-15)) return;
        Normal next = equations();
        // Up to rounding.
        constexpr double kSame = 1e-20;
        if (next.squares() <= normal.squares() + kSame) {
          normal = std::move(next);
          ++steps;
          continue;
        }
        take(before);
        put_all();
      }
      damping *= kMore;
    }
  }

  [[nodiscard]] Normal equations() {
    Normal normal(unknowns_);
    for (std::size_t r = 0; r < placed_.size(); ++r) {
      for (const glm::dvec3& p : points_[r]) {
        normal.add(row_of(r, p), signed_distance(regions_.regions[r].surface, p), 1);
      }
    }
    constexpr double kFirm = 1e9;  // weight of conditions: squares
    for (const auto& [a, b] : right_angles_) {
      const Direction &first = directions_[a], &second = directions_[b];
      Row row;
      const AxisFrame f(first.axis), g(second.axis);
      // Turning an axis by w changes it by w x axis: x -> -y, y -> x of its frame.
      if (first.first >= 0) {
        row.add(first.first, -glm::dot(f.y, second.axis));
        row.add(first.first + 1, glm::dot(f.x, second.axis));
      }
      if (second.first >= 0) {
        row.add(second.first, -glm::dot(g.y, first.axis));
        row.add(second.first + 1, glm::dot(g.x, first.axis));
      }
      normal.add(row, glm::dot(first.axis, second.axis), kFirm);
    }
    const auto add = [&](const RowSum& row, double residual) { normal.add(row, residual, kFirm); };
    for (const std::size_t c : contacts_) each_condition_of(borders_.chains[c], add);
    for (const Meeting& meeting : meetings_) each_condition_of(meeting, add);
    return normal;
  }

  // All that is unknown, to go back to.
  struct Unknowns {
    std::vector<Direction> directions;
    std::vector<Anchor> anchors;
    std::vector<Length> lengths, slopes, places;
  };
  [[nodiscard]] Unknowns unknowns_values() const {
    return {directions_, anchors_, lengths_, slopes_, places_};
  }
  void take(const Unknowns& values) {
    directions_ = values.directions;
    anchors_ = values.anchors;
    lengths_ = values.lengths;
    slopes_ = values.slopes;
    places_ = values.places;
  }

  struct Meeting {
    std::int32_t vertex = 0;
    std::vector<std::size_t> regions;  // the first three tell the point
  };
  // Calls use(row, residual) for the conditions of a contact at places of its chain: both distances
  // are one there, and the normals' parts along it.
  template <class Use>
  void each_condition_of(const BorderChain& chain, const Use& use) const {
    const std::int32_t a = chain.left, b = chain.right;
    const AnalyticRegion &first = regions_.regions[a], &second = regions_.regions[b];
    const double sign = first.side() * second.side();
    const BorderSides sides{{&first.surface, first.side()}, {&second.surface, second.side()}, true};
    for (const double place : kContactPlaces) {
      const AnalyticSurface across = across_chain(chain, place);
      double reach = 0;
      const glm::dvec3 p = sides.point(across.origin, reach, &across),
                       normal_a = normal_at(first.surface, p),
                       normal_b = normal_at(second.surface, p);
      RowSum apart;
      apart.add(row_of(a, p), 1);
      apart.add(row_of(b, p), -sign);
      use(apart, signed_distance(first.surface, p) - sign * signed_distance(second.surface, p));
      // The same a little further along the chain and back: what normals along it differ by.
      glm::dvec3 along = across.axis;
      along -= glm::dot(along, normal_a) * normal_a;
      if (!(glm::length(along) > 0)) continue;
      along = glm::normalize(along);
      constexpr double kStep = 1e-4;
      constexpr double kReach = 0.02;  // what an angle counts for as a length
      const double scale = kReach * 0.5 / kStep;
      RowSum turned;
      for (const double way : {1.0, -1.0})
        turned.add(row_of(a, p + way * kStep * along), way * scale);
      for (const double way : {1.0, -1.0})
        turned.add(row_of(b, p + way * kStep * along), -sign * way * scale);
      use(turned, kReach * glm::dot(along, normal_a - sign * normal_b));
    }
  }

  // Calls use(row, residual) for each surface of a meeting beyond the three that tell its point
  // best: it passes through that.
  template <class Use>
  void each_condition_of(const Meeting& meeting, const Use& use) const {
    std::vector<SidedSurface> three;
    std::array<glm::dvec3, 3> normals;
    const glm::dvec3 near = positions_[meeting.vertex];
    for (std::size_t i = 0; i < 3; ++i)
      three.push_back({&regions_.regions[meeting.regions[i]].surface, 1});
    double reach = 0;
    const glm::dvec3 p = common_point(near, three, {}, reach);
    for (std::size_t i = 0; i < 3; ++i) normals[i] = normal_at(*three[i].surface, p);
    const glm::dmat3 rows = glm::transpose(glm::dmat3(normals[0], normals[1], normals[2]));
    if (!(std::abs(glm::determinant(rows)) > 1e-4)) return;
    const glm::dmat3 inverse = glm::inverse(rows);
    for (std::size_t k = 3; k < meeting.regions.size(); ++k) {
      const AnalyticSurface& other = regions_.regions[meeting.regions[k]].surface;
      // The point moves by -inverse (changes of the three), so the fourth distance changes so.
      const glm::dvec3 shares = glm::transpose(inverse) * normal_at(other, p);
      RowSum moved;
      moved.add(row_of(meeting.regions[k], p), 1);
      for (int i = 0; i < 3; ++i)
        moved.add(row_of(meeting.regions[static_cast<std::size_t>(i)], p), -shares[i]);
      use(moved, signed_distance(other, p));
    }
  }

  // Conditions that more than chance speaks against are none: they would take all surfaces around
  // from their vertices.
  void drop_false_conditions() {
    std::vector<double> deviation(static_cast<std::size_t>(unknowns_), 0);
    const auto set = [&](std::int32_t first, std::int32_t count, double value) {
      for (std::int32_t i = 0; first >= 0 && i < count; ++i) deviation[first + i] = value;
    };
    for (const Direction& direction : directions_) set(direction.first, 2, direction.deviation);
    for (const Anchor& anchor : anchors_) set(anchor.first, 2, anchor.deviation);
    for (const auto* lengths : {&lengths_, &slopes_, &places_})
      for (const Length& length : *lengths) set(length.unknown, 1, length.deviation);
    const auto is_false = [&](const auto& condition) {
      bool result = false;
      each_condition_of(condition, [&](const RowSum& row, double residual) {
        constexpr double kMostTold = 1e-3;  // of the diagonal
        double told = kLeastError;
        for (std::size_t i = 0; i < row.unknowns.size(); ++i)
          told += std::abs(row.values[i]) * deviation[row.unknowns[i]];
        if (!(std::abs(residual) <= kTimes * told && told <= kMostTold)) result = true;
      });
      return result;
    };
    std::erase_if(contacts_, [&](std::size_t c) {
      if (!is_false(borders_.chains[c])) return false;
      is_tangent_[c] = 0;
      return true;
    });
    std::erase_if(meetings_, is_false);
  }
  // Whether a surface passes the point of the first three, as far as vertices tell: a vertex that
  // is a sample may be where two edges only come near each other.
  [[nodiscard]] bool passes_near(const Meeting& meeting, std::size_t region) const {
    std::vector<SidedSurface> three;
    double error = regions_.regions[region].error;
    for (const std::size_t r : meeting.regions) {
      three.push_back({&regions_.regions[r].surface, 1});
      error = std::max(error, regions_.regions[r].error);
    }
    double reach = 0;
    const glm::dvec3 p = common_point(positions_[meeting.vertex], three, {}, reach);
    constexpr double kMost = 4;
    return std::abs(signed_distance(regions_.regions[region].surface, p)) <=
           kMost * std::max(error, 10 * kLeastError);
  }
  void find_meetings() {
    std::map<std::int32_t, std::vector<std::size_t>> at;
    for (std::size_t c = 0; c < borders_.chains.size(); ++c) {
      const BorderChain& chain = borders_.chains[c];
      if (chain.is_closed) continue;
      for (const std::int32_t v : {chain.vertices.front(), chain.vertices.back()})
        for (const std::int32_t r : {chain.left, chain.right})
          if (r >= 0) at[v].push_back(r);
    }
    for (auto& [vertex, regions] : at) {
      std::ranges::sort(regions);
      regions.erase(std::ranges::unique(regions).begin(), regions.end());
      if (regions.size() < 4) continue;
      const glm::dvec3& p = positions_[vertex];
      double best = 0;
      std::array<std::size_t, 3> three{};
      for (std::size_t i = 0; i < regions.size(); ++i)
        for (std::size_t j = i + 1; j < regions.size(); ++j)
          for (std::size_t k = j + 1; k < regions.size(); ++k) {
            const double volume =
                std::abs(glm::dot(normal_at(regions_.regions[regions[i]].surface, p),
                                  glm::cross(normal_at(regions_.regions[regions[j]].surface, p),
                                             normal_at(regions_.regions[regions[k]].surface, p))));
            if (volume <= best) continue;
            best = volume;
            three = {i, j, k};
          }
      if (!(best > 1e-2)) continue;
      Meeting meeting{vertex, {regions[three[0]], regions[three[1]], regions[three[2]]}};
      for (std::size_t i = 0; i < regions.size(); ++i)
        if (std::ranges::find(three, i) == three.end() && passes_near(meeting, regions[i]))
          meeting.regions.push_back(regions[i]);
      meetings_.push_back(std::move(meeting));
    }
  }

  void step(const std::vector<double>& by) {
    // Axes and what is placed along them turn about the anchors, which stay.
    for (Anchor& anchor : anchors_) {
      if (anchor.first < 0) continue;
      const AxisFrame frame(directions_[anchor.direction].axis);
      anchor.point += by[anchor.first] * frame.x + by[anchor.first + 1] * frame.y;
    }
    for (Direction& direction : directions_) {
      if (direction.first < 0) continue;
      const AxisFrame frame(direction.axis);
      const glm::dvec3 turn = by[direction.first] * frame.x + by[direction.first + 1] * frame.y;
      direction.axis = glm::normalize(direction.axis + glm::cross(turn, direction.axis));
    }
    for (auto* lengths : {&lengths_, &slopes_, &places_})
      for (Length& length : *lengths)
        if (length.unknown >= 0) length.value += by[length.unknown];
  }

  // Of a region's vertices, from its surface: the largest.
  [[nodiscard]] double error_of(std::size_t r) const {
    double error = 0;
    for (const glm::dvec3& p : points_[r])
      error = std::max(error, std::abs(signed_distance(regions_.regions[r].surface, p)));
    return error;
  }
  static double most_error(const AnalyticRegion& before) {
    constexpr double kWorse = 2;
    return std::max(kWorse * before.error, 10 * kLeastError);
  }

  // Where surfaces were taken from their vertices: of the conditions around each the one that pulls
  // hardest, by what is left of it against its weight (Baarda's data snooping). Whether any was.
  bool drop_pulling_conditions(const std::vector<AnalyticRegion>& before) {
    std::vector<char> is_pulled(before.size(), 0);
    for (std::size_t r = 0; r < before.size(); ++r)
      is_pulled[r] = error_of(r) > most_error(before[r]) ? 1 : 0;
    const auto force_of = [&](const auto& condition) {
      double force = 0;
      each_condition_of(condition, [&](const RowSum&, double residual) {
        force = std::max(force, std::abs(residual));
      });
      return force;
    };
    struct Pull {
      double force = 0;
      std::ptrdiff_t contact = -1, meeting = -1;
    };
    std::map<std::size_t, Pull> hardest;  // by pulled region
    const auto consider = [&](std::size_t r, const Pull& pull) {
      if (is_pulled[r] != 0 && pull.force > hardest[r].force) hardest[r] = pull;
    };
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const BorderChain& chain = borders_.chains[contacts_[i]];
      if (is_pulled[chain.left] == 0 && is_pulled[chain.right] == 0) continue;
      const Pull pull{force_of(chain), static_cast<std::ptrdiff_t>(i), -1};
      consider(chain.left, pull);
      consider(chain.right, pull);
    }
    for (std::size_t i = 0; i < meetings_.size(); ++i) {
      if (std::ranges::none_of(meetings_[i].regions,
                               [&](std::size_t r) { return is_pulled[r] != 0; }))
        continue;
      const Pull pull{force_of(meetings_[i]), -1, static_cast<std::ptrdiff_t>(i)};
      for (const std::size_t r : meetings_[i].regions) consider(r, pull);
    }
    std::vector<std::ptrdiff_t> contacts, meetings;
    for (const auto& [region, pull] : hardest) {
      if (pull.contact >= 0) contacts.push_back(pull.contact);
      if (pull.meeting >= 0) meetings.push_back(pull.meeting);
    }
    for (auto* list : {&contacts, &meetings}) {
      std::ranges::sort(*list, std::greater<>());
      list->erase(std::ranges::unique(*list).begin(), list->end());
    }
    for (const std::ptrdiff_t i : contacts) {
      is_tangent_[contacts_[static_cast<std::size_t>(i)]] = 0;
      contacts_.erase(contacts_.begin() + i);
    }
    for (const std::ptrdiff_t i : meetings) meetings_.erase(meetings_.begin() + i);
    return !contacts.empty() || !meetings.empty();
  }

  // A surface that the conditions took from its vertices gets its own back.
  void keep_near(const std::vector<AnalyticRegion>& before) {
    for (std::size_t r = 0; r < before.size(); ++r) {
      const double error = error_of(r);
      if (error <= most_error(before[r])) {
        regions_.regions[r].error = error;
      } else {
        regions_.regions[r].surface = before[r].surface;
      }
    }
  }

  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  const RegionBorders& borders_;
  AnalyticRegions& regions_;
  std::vector<std::vector<glm::dvec3>> points_;
  std::vector<Certainty> certainties_;
  std::vector<Placed> placed_;
  std::vector<Direction> directions_;
  std::vector<Anchor> anchors_;
  std::vector<Length> lengths_, slopes_, places_;
  std::vector<std::array<std::int32_t, 2>> right_angles_;
  std::vector<char> is_tangent_;
  std::vector<std::size_t> contacts_;
  std::vector<Meeting> meetings_;
  std::int32_t unknowns_ = 0;
};

}  // namespace

SettledRegions settle_surfaces(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                               const RegionBorders& borders, AnalyticRegions& regions) {
  // Twice where vertices are noisy: lengths that conditions have brought together are one then.
  SettledRegions settled = Settler(positions, topology, borders, regions).settle();
  if (std::ranges::any_of(regions.regions, is_noisy))
    settled = Settler(positions, topology, borders, regions).settle();
  return settled;
}

glm::dvec3 BorderSides::point(const glm::dvec3& near, double& reach,
                              const AnalyticSurface* cut) const {
  constexpr std::array<std::array<std::size_t, 2>, 1> kBoth{{{0, 1}}};
  const std::array<SidedSurface, 3> all{left, right, SidedSurface{cut, 1}};
  return common_point(near, std::span(all).first(cut != nullptr ? 3 : 2),
                      std::span(kBoth).first(is_tangent ? 1 : 0), reach);
}

glm::dvec3 common_point(const glm::dvec3& near, std::span<const SidedSurface> surfaces,
                        std::span<const std::array<std::size_t, 2>> touching, double& reach) {
  glm::dvec3 p = near;
  constexpr double kSize = 0.02;  // what an angle counts for as a length
  constexpr int kSteps = 30;
  for (int step = 0; step < kSteps; ++step) {
    glm::dmat3 matrix(0.0);
    glm::dvec3 right(0.0);
    const auto add = [&](const glm::dvec3& gradient, double residual) {
      for (int i = 0; i < 3; ++i) matrix[i] += gradient[i] * gradient;
      right -= residual * gradient;
    };
    for (const SidedSurface& s : surfaces)
      add(normal_at(*s.surface, p), signed_distance(*s.surface, p));
    for (const auto& [a, b] : touching) {
      const SidedSurface &first = surfaces[a], &second = surfaces[b];
      const auto apart = [&](const glm::dvec3& at) {
        return kSize * (first.side * normal_at(*first.surface, at) -
                        second.side * normal_at(*second.surface, at));
      };
      const glm::dvec3 here = apart(p);
      constexpr double kStep = 1e-6;
      glm::dmat3 by;  // columns: change of `apart` by each coordinate
      for (int i = 0; i < 3; ++i) {
        glm::dvec3 d(0.0);
        d[i] = kStep;
        by[i] = (apart(p + d) - apart(p - d)) / (2 * kStep);
      }
      const glm::dmat3 rows = glm::transpose(by);
      for (int i = 0; i < 3; ++i) add(rows[i], here[i]);
    }
    const double ridge = 1e-10 * (matrix[0][0] + matrix[1][1] + matrix[2][2]);
    for (int i = 0; i < 3; ++i) matrix[i][i] += ridge;
    const glm::dvec3 move = glm::inverse(matrix) * right;
    if (!std::isfinite(move.x + move.y + move.z)) break;
    p += move;
    if (glm::length(move) < 1e-15) break;
  }
  reach = 0;
  for (const SidedSurface& s : surfaces)
    reach = std::max(reach, std::abs(signed_distance(*s.surface, p)));
  return p;
}

}  // namespace planish
