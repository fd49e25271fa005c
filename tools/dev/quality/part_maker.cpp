#include "quality/part_maker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "make_scenes/sample_points.h"
#include "make_scenes/shapes.h"

namespace planish::quality {
namespace {

using glm::dvec2;

constexpr double kFullTurn = 2 * std::numbers::pi;

double area_of(const dvec2& a, const dvec2& b, const dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The profile's points, one loop after another, and a single polygon over them in which bridges to
// the holes run forth and back.
struct Keyhole {
  std::vector<dvec2> points;
  std::vector<std::int32_t> polygon;

  [[nodiscard]] bool crosses(std::int32_t a, std::int32_t b) const;
  void bridge(std::vector<std::int32_t> hole);
};

bool Keyhole::crosses(std::int32_t a, std::int32_t b) const {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::int32_t c = polygon[i], d = polygon[(i + 1) % polygon.size()];
    if (c == a || c == b || d == a || d == b) continue;
    const dvec2 &p = points[a], &q = points[b], &r = points[c], &s = points[d];
    if (area_of(p, q, r) * area_of(p, q, s) <= 0 && area_of(r, s, p) * area_of(r, s, q) <= 0) {
      return true;
    }
  }
  return false;
}

// From the hole's rightmost vertex to the nearest one of the polygon that it sees.
void Keyhole::bridge(std::vector<std::int32_t> hole) {
  const auto rightmost = std::max_element(
      hole.begin(), hole.end(), [&](auto a, auto b) { return points[a].x < points[b].x; });
  std::rotate(hole.begin(), rightmost, hole.end());
  const auto distance = [&](std::size_t i) {
    return std::hypot(points[polygon[i]].x - points[hole[0]].x,
                      points[polygon[i]].y - points[hole[0]].y);
  };
  std::vector<std::size_t> order(polygon.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return distance(a) < distance(b); });
  for (const std::size_t i : order) {
    if (points[polygon[i]].x < points[hole[0]].x || crosses(polygon[i], hole[0])) continue;
    hole.push_back(hole[0]);
    hole.push_back(polygon[i]);
    polygon.insert(polygon.begin() + static_cast<std::ptrdiff_t>(i) + 1, hole.begin(), hole.end());
    return;
  }
  throw std::invalid_argument("a hole outside its profile");
}

bool is_ear(const Keyhole& shape, std::size_t i) {
  const auto n = shape.polygon.size();
  const std::int32_t ear[] = {shape.polygon[(i + n - 1) % n], shape.polygon[i],
                              shape.polygon[(i + 1) % n]};
  const dvec2 &a = shape.points[ear[0]], &b = shape.points[ear[1]], &c = shape.points[ear[2]];
  if (!(area_of(a, b, c) > 1e-12)) return false;
  return std::none_of(shape.polygon.begin(), shape.polygon.end(), [&](std::int32_t v) {
    if (v == ear[0] || v == ear[1] || v == ear[2]) return false;
    const dvec2& p = shape.points[v];
    return area_of(a, b, p) >= 0 && area_of(b, c, p) >= 0 && area_of(c, a, p) >= 0;
  });
}

std::vector<std::array<std::int32_t, 3>> cut_ears(Keyhole shape) {
  std::vector<std::array<std::int32_t, 3>> triangles;
  while (shape.polygon.size() > 2) {
    const auto n = shape.polygon.size();
    std::size_t ear = 0;
    while (ear < n && !is_ear(shape, ear)) ++ear;
    if (ear == n) throw std::invalid_argument("a profile that crosses itself");
    triangles.push_back(
        {shape.polygon[(ear + n - 1) % n], shape.polygon[ear], shape.polygon[(ear + 1) % n]});
    shape.polygon.erase(shape.polygon.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  return triangles;
}

// With its holes bridged, the rightmost first: the others see past its bridge. And all loops.
std::pair<Keyhole, std::vector<std::vector<std::int32_t>>> bridged(const Profile& profile) {
  Keyhole shape;
  std::vector<std::vector<std::int32_t>> loops;
  const auto add_loop = [&](const Loop& loop) {
    std::vector<std::int32_t>& indices = loops.emplace_back(loop.size());
    std::iota(indices.begin(), indices.end(), static_cast<std::int32_t>(shape.points.size()));
    shape.points.insert(shape.points.end(), loop.begin(), loop.end());
  };
  add_loop(profile.outline);
  for (const Loop& hole : profile.holes) add_loop(hole);
  shape.polygon = loops[0];
  std::stable_sort(loops.begin() + 1, loops.end(), [&](const auto& a, const auto& b) {
    const auto right = [&](const std::vector<std::int32_t>& loop) {
      double x = -HUGE_VAL;
      for (const std::int32_t v : loop) x = std::max(x, shape.points[v].x);
      return x;
    };
    return right(a) > right(b);
  });
  for (std::size_t i = 1; i < loops.size(); ++i) shape.bridge(loops[i]);
  return {std::move(shape), std::move(loops)};
}

Loop arc(const dvec2& centre, double radius, double from, double to, std::int32_t count) {
  Loop points;
  for (std::int32_t i = 0; i <= count; ++i) {
    const double angle = from + (to - from) * i / count;
    points.emplace_back(centre.x + radius * std::cos(angle), centre.y + radius * std::sin(angle));
  }
  return points;
}

}  // namespace

Loop circle(const dvec2& centre, double radius, std::int32_t count) {
  Loop points = arc(centre, radius, 0, kFullTurn, count);
  points.pop_back();
  return points;
}

Loop round_hole(const dvec2& centre, double radius, std::int32_t count) {
  Loop points = circle(centre, radius, count);
  std::reverse(points.begin(), points.end());
  return points;
}

std::vector<std::array<std::int32_t, 3>> ears_of(const Profile& profile) {
  return cut_ears(bridged(profile).first);
}

PolygonMesh extruded_part(const Profile& profile, double height) {
  const auto [shape, loops] = bridged(profile);
  const auto n = static_cast<std::int32_t>(shape.points.size());
  PolygonMesh mesh;
  for (const double z : {0.0, height}) {
    for (const dvec2& p : shape.points) mesh.positions.emplace_back(p.x, p.y, z);
  }
  for (const auto& [a, b, c] : cut_ears(shape)) {
    mesh.add_face(std::array{a, c, b});
    mesh.add_face(std::array{a + n, b + n, c + n});
  }
  for (const std::vector<std::int32_t>& loop : loops) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::int32_t a = loop[i], b = loop[(i + 1) % loop.size()];
      mesh.add_face(std::array{a, b, b + n});
      mesh.add_face(std::array{a, b + n, a + n});
    }
  }
  return mesh;
}

PolygonMesh l_part(const PartSize& size) {
  const double leg = 4 * size.length, width = 1, fillet = 0.6;
  Profile profile;
  profile.outline = {{0, 0}, {leg, 0}, {leg, width}};
  const Loop bend = arc({width + fillet, width + fillet}, fillet, 0.75 * kFullTurn, 0.5 * kFullTurn,
                        std::max(2, size.segments / 4));
  profile.outline.insert(profile.outline.end(), bend.begin(), bend.end());
  profile.outline.insert(profile.outline.end(), {{width, leg}, {0, leg}});
  profile.holes = {round_hole({0.7 * leg, 0.5}, 0.3, size.segments),
                   round_hole({0.5, 0.7 * leg}, 0.25, size.segments)};
  return extruded_part(profile, 0.5);
}

PolygonMesh drilled_plate(const PartSize& size, std::int32_t holes) {
  const double length = 2 * size.length * holes;
  Profile profile;
  profile.outline = {{0, 0}, {length, 0}, {length, 3}, {0, 3}};
  for (std::int32_t i = 0; i < holes; ++i) {
    const double radius = 0.25 + 0.5 * i / holes;
    profile.holes.push_back(
        round_hole({(i + 0.5) * length / holes, 1.3 + 0.2 * (i % 3)}, radius, size.segments));
  }
  return extruded_part(profile, 0.4);
}

PolygonMesh gear(const PartSize& size, std::int32_t teeth) {
  Profile profile;
  for (std::int32_t i = 0; i < teeth; ++i) {
    for (const auto& [part, radius] :
         {std::pair(0.0, 1.0), {0.15, 1.25}, {0.4, 1.25}, {0.55, 1.0}}) {
      const double angle = kFullTurn * (i + part) / teeth;
      profile.outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
  }
  profile.holes = {round_hole({0, 0}, 0.3, size.segments)};
  return extruded_part(profile, 0.3 * size.length);
}

PolygonMesh rod(const PartSize& size) {
  return extruded_part({circle({0, 0}, 0.5, size.segments), {}}, size.length);
}

PolygonMesh pipe(const PartSize& size) {
  return extruded_part(
      {circle({0, 0}, 0.5, size.segments), {round_hole({0, 0}, 0.4, size.segments)}}, size.length);
}

namespace {

using glm::dvec3;
using Ring = std::vector<dvec3>;

constexpr double kRadians = std::numbers::pi / 180;

dvec2 turned(const dvec2& v, double degrees) {
  const double c = std::cos(degrees * kRadians), s = std::sin(degrees * kRadians);
  return {c * v.x - s * v.y, s * v.x + c * v.y};
}

// What a list of knots is: whether the last one leads to the first, and whether x = 0 is an axis,
// which smooth curves meet at a right angle.
struct Path {
  const Knots& knots;
  bool is_closed, is_profile = false;

  [[nodiscard]] std::size_t side_count() const { return knots.size() - (is_closed ? 0 : 1); }
  [[nodiscard]] dvec2 place(std::size_t i) const {
    const Knot& knot = knots[i % knots.size()];
    return {knot.x, knot.y};
  }
  [[nodiscard]] dvec2 chord(std::size_t side) const { return place(side + 1) - place(side); }
  [[nodiscard]] bool is_curve(std::size_t side) const { return knots[side].turn == kCurve; }
  // Of a curve at an end of one of its sides, as long as one.
  [[nodiscard]] dvec2 curve_tangent(std::size_t side, bool at_end) const;
  // Unit vectors along a side at its ends.
  [[nodiscard]] dvec2 direction(std::size_t side, bool at_end) const;
};

dvec2 Path::curve_tangent(std::size_t side, bool at_end) const {
  const std::size_t n = side_count(), step = at_end ? 1 : n - 1;
  const std::size_t beside = (side + step) % n;
  const dvec2 own = chord(side);
  const bool has_more = is_closed || (at_end ? side + 1 < n : side > 0);
  if (has_more && is_curve(beside)) {
    const dvec2 other = chord(beside);
    const double a = glm::length(own), b = glm::length(other);
    return (own / a * b + other / b * a) / (a + b);
  }
  if (is_profile && place(side + (at_end ? 1 : 0)).x == 0) return {own.x < 0 ? -1.0 : 1.0, 0};
  // As a parabola ends; a curve of one side is straight.
  const bool is_alone = !is_closed && n == 1;
  const std::size_t before = (side + (at_end ? n - 1 : 1)) % n;
  if (is_alone || !is_curve(before)) return own / glm::length(own);
  return 2.0 * own / glm::length(own) - curve_tangent(side, !at_end);
}

dvec2 Path::direction(std::size_t side, bool at_end) const {
  if (is_curve(side)) return glm::normalize(curve_tangent(side, at_end));
  return turned(glm::normalize(chord(side)), (at_end ? 0.5 : -0.5) * knots[side].turn);
}

struct Sample {
  dvec2 place, along;
};

Sample sample_at(const Path& path, std::size_t side, double t) {
  const dvec2 from = path.place(side), chord = path.chord(side);
  const double turn = path.knots[side].turn;
  if (path.is_curve(side)) {
    const double length = glm::length(chord), u = 1 - t;
    const dvec2 a = length * path.curve_tangent(side, false);
    const dvec2 b = length * path.curve_tangent(side, true);
    return {from + t * t * (3 - 2 * t) * chord + t * u * (u * a - t * b),
            6 * t * u * chord + u * (1 - 3 * t) * a + t * (3 * t - 2) * b};
  }
  const dvec2 along = turned(path.direction(side, false), t * turn);
  if (turn == 0) return {from + t * chord, along};
  const double share = std::sin(0.5 * t * turn * kRadians) / std::sin(0.5 * turn * kRadians);
  return {from + share * turned(chord, -0.5 * (1 - t) * turn), along};
}

std::vector<Sample> samples_of(const Path& path, std::int32_t fineness) {
  std::vector<Sample> samples;
  for (std::size_t side = 0; side < path.side_count(); ++side) {
    const Knot& knot = path.knots[side];
    const std::int32_t steps = knot.turn == 0 ? 1 : knot.steps * fineness;
    for (std::int32_t i = 0; i < steps; ++i)
      samples.push_back(sample_at(path, side, static_cast<double>(i) / steps));
  }
  if (!path.is_closed) samples.push_back(sample_at(path, path.side_count() - 1, 1));
  return samples;
}

Loop places_of(const Path& path, std::int32_t fineness) {
  Loop places;
  for (const Sample& sample : samples_of(path, fineness)) places.push_back(sample.place);
  return places;
}

// A closed outline, each side moved to its left by `distance`: arcs that go on into their
// neighbours smoothly keep their centres.
Knots inset(const Knots& outline, double distance) {
  const Path path{outline, true};
  Knots moved = outline;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const dvec2 in = path.direction((i + outline.size() - 1) % outline.size(), true);
    const dvec2 out = path.direction(i, false);
    const dvec2 normals(-in.y - out.y, in.x + out.x);
    const dvec2 shift = normals * (distance / (1 + glm::dot(in, out)));
    moved[i].x += shift.x;
    moved[i].y += shift.y;
  }
  return moved;
}

class Net {
 public:
  explicit Net(const Cut& cut) : cut_(cut) {}

  // Rings of as many places each, one joined to the next; one whose places are the same is a point.
  void add(const std::vector<Ring>& rings, bool is_closed, bool has_ends = true) {
    std::vector<std::vector<std::int32_t>> numbers;
    for (const Ring& ring : rings) numbers.push_back(add_ring(ring));
    for (std::size_t r = 0; r + (is_closed ? 0 : 1) < rings.size(); ++r)
      add_band(numbers[r], numbers[(r + 1) % rings.size()]);
    if (is_closed || !has_ends) return;
    add_end({numbers.front().rbegin(), numbers.front().rend()});
    add_end(numbers.back());
  }

  // A flat end with holes, whose vertices are those numbers.
  void add_ears(const Profile& profile, const std::vector<std::int32_t>& numbers, bool is_up) {
    for (const auto& [a, b, c] : ears_of(profile))
      add_face({numbers[a], numbers[is_up ? b : c], numbers[is_up ? c : b]});
  }

  PolygonMesh mesh;

 private:
  std::vector<std::int32_t> add_ring(const Ring& ring) {
    const bool is_point = std::ranges::all_of(
        ring, [&](const dvec3& p) { return glm::distance(p, ring[0]) < 1e-12; });
    std::vector<std::int32_t> numbers(ring.size(), mesh.vertex_count());
    if (!is_point) std::iota(numbers.begin(), numbers.end(), mesh.vertex_count());
    mesh.positions.insert(mesh.positions.end(), ring.begin(),
                          is_point ? ring.begin() + 1 : ring.end());
    return numbers;
  }

  void add_face(std::initializer_list<std::int32_t> corners) { shapes::add_face(mesh, corners); }

  void add_band(const std::vector<std::int32_t>& low, const std::vector<std::int32_t>& high) {
    for (std::size_t i = 0; i < low.size(); ++i) {
      const std::size_t j = (i + 1) % low.size();
      const std::int32_t a = low[i], b = low[j], c = high[j], d = high[i];
      if (a == b && c == d) continue;
      if (a == b) {
        add_face({a, c, d});
      } else if (c == d) {
        add_face({a, b, c});
      } else if (cut_.sides == Sides::Quads) {
        add_face({a, b, c, d});
      } else if (is_first_diagonal({a, b, c, d}, i)) {
        add_face({a, b, c});
        add_face({a, c, d});
      } else {
        add_face({a, b, d});
        add_face({b, c, d});
      }
    }
  }

  bool is_first_diagonal(const std::array<std::int32_t, 4>& corners, std::size_t i) {
    const auto length = [&](int from, int to) {
      return glm::distance(mesh.positions[corners[from]], mesh.positions[corners[to]]);
    };
    switch (cut_.sides) {
      case Sides::ZigZag:
        return i % 2 == 0;
      case Sides::Lot:
        return lot_.below(2) == 0;
      case Sides::Short:
        return length(0, 2) <= length(1, 3) + 1e-9;
      default:
        return true;
    }
  }

  void add_end(const std::vector<std::int32_t>& ring) {
    const std::size_t n = ring.size();
    if (ring[0] == ring[1]) return;
    switch (n > 4 || cut_.sides != Sides::Quads ? cut_.ends : Ends::Polygon) {
      case Ends::Polygon:
        mesh.add_face(ring);
        break;
      case Ends::Hub: {
        if (n == 4) {
          add_fan(ring);
          break;
        }
        dvec3 middle(0.0);
        for (const std::int32_t v : ring) middle += mesh.positions[v] / static_cast<double>(n);
        mesh.positions.push_back(middle);
        for (std::size_t i = 0; i < n; ++i)
          add_face({mesh.vertex_count() - 1, ring[i], ring[(i + 1) % n]});
        break;
      }
      case Ends::Rim:
        add_fan(ring);
        break;
      case Ends::Strip:
        for (std::size_t low = 0, high = n - 1; low + 1 < high;) {
          add_face({ring[low], ring[low + 1], ring[high]});
          if (++low + 1 >= high) break;
          add_face({ring[low], ring[high - 1], ring[high]});
          --high;
        }
        break;
      case Ends::Ears:
        add_ear_end(ring);
        break;
    }
  }

  void add_fan(const std::vector<std::int32_t>& ring) {
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) add_face({ring[0], ring[i], ring[i + 1]});
  }

  // Seen along the axis that is nearest to the end's normal.
  void add_ear_end(const std::vector<std::int32_t>& ring) {
    dvec3 normal(0.0);
    for (std::size_t i = 0; i < ring.size(); ++i)
      normal += glm::cross(mesh.positions[ring[i]], mesh.positions[ring[(i + 1) % ring.size()]]);
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
    const int x = (axis + (normal[axis] > 0 ? 1 : 2)) % 3, y = 3 - axis - x;
    Profile profile;
    for (const std::int32_t v : ring)
      profile.outline.emplace_back(mesh.positions[v][x], mesh.positions[v][y]);
    for (const auto& [a, b, c] : ears_of(profile)) add_face({ring[a], ring[b], ring[c]});
  }

  Cut cut_;
  shapes::RandomNumbers lot_{17};
};

PolygonMesh net_of(const std::vector<Ring>& rings, const Cut& cut, bool is_closed) {
  Net net(cut);
  net.add(rings, is_closed);
  return std::move(net.mesh);
}

// A round section about each place of a line; `up` is nowhere along it.
PolygonMesh wire_along(std::int32_t fineness, const std::vector<std::pair<dvec3, dvec3>>& line,
                       const dvec3& up, double radius, std::int32_t segments, const Cut& cut,
                       double bore_radius) {
  const Loop round = places_of({disc(segments, 1), true}, fineness);
  std::vector<Ring> rings;
  const auto add = [&](const std::pair<dvec3, dvec3>& at, double r) {
    const dvec3 x = glm::normalize(glm::cross(at.second, up));
    const dvec3 y = glm::normalize(glm::cross(at.second, x));
    Ring& ring = rings.emplace_back();
    for (const dvec2& p : round) ring.push_back(at.first + r * (p.x * x + p.y * y));
  };
  for (const auto& at : line) add(at, radius);
  if (bore_radius > 0)
    for (std::size_t i = line.size(); i-- > 0;) add(line[i], bore_radius);
  return net_of(rings, cut, bore_radius > 0);
}

// Smooth through the values at 0, 1, 2, ...; or straight.
template <class Value>
Value between(const std::function<Value(std::int32_t)>& at, std::int32_t i, double t,
              std::int32_t count, bool is_smooth) {
  const Value a = at(i), b = at(i + 1);
  if (!is_smooth) return a + t * (b - a);
  const auto slope = [&](std::int32_t k) {
    if (k == 0) return 2.0 * (at(1) - at(0)) - 0.5 * (at(std::min(2, count - 1)) - at(0));
    if (k + 1 == count) return 2.0 * (at(k) - at(k - 1)) - 0.5 * (at(k) - at(std::max(0, k - 2)));
    return 0.5 * (at(k + 1) - at(k - 1));
  };
  const double u = 1 - t;
  return a + t * t * (3 - 2 * t) * (b - a) + t * u * (u * slope(i) - t * slope(i + 1));
}

}  // namespace

Knots::Knots(const char* text) {
  std::istringstream words(text);
  for (std::string knot; std::getline(words, knot, ',');) {
    std::istringstream parts(knot);
    Knot& made = emplace_back();
    char mark = 0, slash = 0;
    if (!(parts >> made.x >> made.y)) throw std::invalid_argument("knots: " + knot);
    if (!(parts >> mark)) continue;
    if (mark == '~') made.turn = kCurve;
    if (mark == '@') parts >> made.turn >> slash >> made.steps;
    if (!parts) throw std::invalid_argument("knots: " + knot);
  }
}

Knots rectangle(double x, double y) {
  return {{x / 2, -y / 2}, {x / 2, y / 2}, {-x / 2, y / 2}, {-x / 2, -y / 2}};
}

Knots rounded_rectangle(double x, double y, double radius, std::int32_t steps) {
  const double a = x / 2, b = y / 2, c = a - radius, d = b - radius;
  return {{a, -d}, {a, d, 90, steps},   {c, b},   {-c, b, 90, steps},
          {-a, d}, {-a, -d, 90, steps}, {-c, -b}, {c, -b, 90, steps}};
}

Knots even_polygon(std::int32_t sides, double radius) {
  Knots knots;
  for (std::int32_t i = 0; i < sides; ++i) {
    const dvec2 p = turned({radius, 0}, 360.0 * i / sides);
    knots.push_back({p.x, p.y});
  }
  return knots;
}

Knots disc(std::int32_t segments, double radius, const dvec2& centre) {
  return {{centre.x + radius, centre.y, 180, segments / 2},
          {centre.x - radius, centre.y, 180, segments - segments / 2}};
}

Knots bore(std::int32_t segments, double radius, const dvec2& centre) {
  Knots knots = disc(segments, radius, centre);
  for (Knot& knot : knots) knot.turn = -knot.turn;
  return knots;
}

PolygonMesh lathe(std::int32_t fineness, const Knots& profile, std::int32_t segments,
                  const Cut& cut, bool is_ring) {
  constexpr std::int32_t kFlatSides = 6;  // and fewer
  const std::int32_t n = segments <= kFlatSides ? segments : segments * fineness;
  // What is fine is the true shape, however uneven the coarse one is.
  const double sway = fineness > 1 || segments <= kFlatSides ? 0 : 360 * cut.unevenness / n;
  shapes::RandomNumbers lot(5);
  std::vector<Ring> rings;
  for (const dvec2& p : places_of({profile, is_ring, true}, fineness)) {
    Ring& ring = rings.emplace_back();
    for (std::int32_t i = 0; i < n; ++i)
      ring.emplace_back(turned({p.x, 0}, 360.0 * i / n + sway * lot.sway()), p.y);
  }
  return net_of(rings, cut, is_ring);
}

PolygonMesh solid(std::int32_t fineness, const Knots& outline, const Knots& side, const Cut& cut,
                  const std::vector<Knots>& holes) {
  const Loop levels = places_of({side, false}, fineness);
  const auto loop_at = [&](const Knots& knots, std::size_t level) {
    return places_of({inset(knots, levels[level].x), true}, fineness);
  };
  const auto rings_of = [&](const Knots& knots) {
    std::vector<Ring> rings;
    for (std::size_t level = 0; level < levels.size(); ++level) {
      Ring& ring = rings.emplace_back();
      for (const dvec2& p : loop_at(knots, level)) ring.emplace_back(p, levels[level].y);
    }
    return rings;
  };
  if (holes.empty()) return net_of(rings_of(outline), cut, false);
  // The vertices of each level in a row, as its ends want them.
  Net net(cut);
  std::vector<std::vector<Ring>> walls{rings_of(outline)};
  for (const Knots& hole : holes) walls.push_back(rings_of(hole));
  for (const std::vector<Ring>& wall : walls) net.add(wall, false, false);
  for (const bool is_up : {false, true}) {
    const std::size_t level = is_up ? levels.size() - 1 : 0;
    Profile profile{loop_at(outline, level), {}};
    for (const Knots& hole : holes) profile.holes.push_back(loop_at(hole, level));
    std::vector<std::int32_t> numbers;
    std::int32_t first = 0;
    for (const std::vector<Ring>& wall : walls) {
      const auto n = static_cast<std::int32_t>(wall[0].size());
      for (std::int32_t i = 0; i < n; ++i)
        numbers.push_back(first + static_cast<std::int32_t>(level) * n + i);
      first += static_cast<std::int32_t>(wall.size()) * n;
    }
    net.add_ears(profile, numbers, is_up);
  }
  return std::move(net.mesh);
}

PolygonMesh loft(std::int32_t fineness, const Knots& section, const std::vector<Station>& stations,
                 bool is_smooth, const Cut& cut) {
  const Loop loop = places_of({section, true}, fineness);
  const auto count = static_cast<std::int32_t>(stations.size());
  const std::int32_t steps = is_smooth ? fineness : 1;
  std::vector<Ring> rings;
  for (std::int32_t k = 0; k <= (count - 1) * steps; ++k) {
    const std::int32_t i = std::min(k / steps, count - 2);
    const double t = static_cast<double>(k) / steps - i;
    const auto number = [&](const std::function<double(std::int32_t)>& at) {
      return between(at, i, t, count, is_smooth);
    };
    const auto pair = [&](const std::function<dvec2(std::int32_t)>& at) {
      return between(at, i, t, count, is_smooth);
    };
    const dvec2 scale = pair([&](std::int32_t s) { return stations[s].scale; });
    const dvec2 shift = pair([&](std::int32_t s) { return stations[s].shift; });
    const double degrees = number([&](std::int32_t s) { return stations[s].degrees; });
    const double z = number([&](std::int32_t s) { return stations[s].z; });
    Ring& ring = rings.emplace_back();
    for (const dvec2& p : loop) ring.emplace_back(turned(scale * p, degrees) + shift, z);
  }
  return net_of(rings, cut, false);
}

PolygonMesh tube(std::int32_t fineness, const Knots& path, double radius, std::int32_t segments,
                 const Cut& cut, double bore_radius) {
  std::vector<std::pair<dvec3, dvec3>> line;
  for (const Sample& at : samples_of({path, false}, fineness))
    line.emplace_back(dvec3(at.place.x, 0, at.place.y), dvec3(at.along.x, 0, at.along.y));
  return wire_along(fineness, line, {0, 1, 0}, radius, segments, cut, bore_radius);
}

PolygonMesh coil(std::int32_t fineness, double turns, double pitch, double radius,
                 std::int32_t steps, double wire, std::int32_t segments, const Cut& cut) {
  const auto count = static_cast<std::int32_t>(std::lround(turns * steps)) * fineness;
  std::vector<std::pair<dvec3, dvec3>> line;
  for (std::int32_t i = 0; i <= count; ++i) {
    const double degrees = 360.0 * turns * i / count;
    line.emplace_back(dvec3(turned({radius, 0}, degrees), pitch * degrees / 360),
                      dvec3(turned({0, radius}, degrees), pitch / 360 / kRadians));
  }
  return wire_along(fineness, line, {0, 0, 1}, wire, segments, cut, 0);
}

PolygonMesh placed(PolygonMesh mesh, const dvec3& shift, const dvec3& degrees) {
  for (dvec3& p : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      const int x = (axis + 1) % 3, y = (axis + 2) % 3;
      const dvec2 v = turned({p[x], p[y]}, degrees[axis]);
      p[x] = v.x;
      p[y] = v.y;
    }
    p += shift;
  }
  return mesh;
}

PolygonMesh joined(const std::vector<PolygonMesh>& meshes) {
  PolygonMesh all;
  for (const PolygonMesh& mesh : meshes) {
    const std::int32_t first = all.vertex_count();
    all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      std::vector<std::int32_t> corners(mesh.face(f).begin(), mesh.face(f).end());
      for (std::int32_t& v : corners) v += first;
      all.add_face(corners);
    }
  }
  return all;
}

PolygonMesh around_axis(const PolygonMesh& mesh, std::int32_t count) {
  std::vector<PolygonMesh> all;
  for (std::int32_t i = 0; i < count; ++i)
    all.push_back(placed(mesh, {0, 0, 0}, {0, 0, 360.0 * i / count}));
  return joined(all);
}

PolygonMesh copied(const PolygonMesh& mesh, const std::vector<dvec3>& places) {
  std::vector<PolygonMesh> all;
  for (const dvec3& place : places) all.push_back(placed(mesh, place));
  return joined(all);
}

}  // namespace planish::quality
