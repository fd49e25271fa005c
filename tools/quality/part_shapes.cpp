#include "quality/part_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

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

}  // namespace planish::quality
