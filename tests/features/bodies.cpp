#include "features/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <utility>

#include "planish/mesh/face_geometry.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kFullTurn = 2 * glm::pi<double>();
constexpr double kDegree = kFullTurn / 360;
// An even outline is sharp that turns by 60 degrees, as that of a hexagon does.
constexpr double kSharpTurn = 60;

double turn_at(const Outline2& outline, std::size_t i) {
  const std::size_t n = outline.size();
  const dvec2 in = glm::normalize(outline[i] - outline[(i + n - 1) % n]);
  const dvec2 out = glm::normalize(outline[(i + 1) % n] - outline[i]);
  return std::abs(std::atan2(in.x * out.y - in.y * out.x, glm::dot(in, out))) / kDegree;
}

// By side of an outline its surface: sides that meet at less than 60 degrees are one.
std::vector<std::int32_t> sides_of(const Outline2& outline, std::int32_t first) {
  const std::size_t n = outline.size();
  std::vector<std::int32_t> sides(n, first);
  std::size_t start = 0;
  while (start < n && turn_at(outline, start) < kSharpTurn - 1e-6) ++start;
  if (start == n) return sides;
  std::int32_t surface = first;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = (start + k) % n;
    if (k > 0 && turn_at(outline, i) >= kSharpTurn - 1e-6) ++surface;
    sides[i] = surface;
  }
  return sides;
}

// Rings of as many places each, from the lowest on; `bands` the surface of each place's side, by
// band; ends are faces, or points where all places of a ring are one.
Body body_of_rings(const std::vector<std::vector<dvec3>>& rings,
                   const std::vector<std::vector<std::int32_t>>& bands) {
  Body body;
  const auto n = static_cast<std::int32_t>(rings.front().size());
  std::vector<std::vector<std::int32_t>> number;
  for (const auto& ring : rings) {
    const bool is_point = glm::distance(ring[0], ring[1]) < 1e-12;
    std::vector<std::int32_t> own;
    for (std::int32_t i = 0; i < n; ++i) {
      if (i == 0 || !is_point) body.mesh.positions.push_back(ring[i]);
      own.push_back(body.mesh.vertex_count() - 1);
    }
    number.push_back(own);
  }
  const auto add = [&](std::vector<std::int32_t> face, std::int32_t surface) {
    face.erase(std::unique(face.begin(), face.end()), face.end());
    if (face.front() == face.back()) face.pop_back();
    if (face.size() < 3) return;
    body.mesh.add_face(face);
    body.surfaces.push_back(surface);
  };
  add({number.front().rbegin(), number.front().rend()}, kFacet);
  for (std::size_t r = 0; r + 1 < rings.size(); ++r)
    for (std::int32_t i = 0; i < n; ++i) {
      const std::int32_t j = (i + 1) % n;
      add({number[r][i], number[r][j], number[r + 1][j], number[r + 1][i]}, bands[r][i]);
    }
  add(number.back(), kFacet);
  return body;
}

std::vector<dvec3> ring_of(const Outline2& outline, double z, double scale = 1) {
  std::vector<dvec3> ring;
  for (const dvec2& p : outline) ring.emplace_back(scale * p, z);
  return ring;
}

Body extruded_body(const Outline2& outline, double height) {
  return body_of_rings({ring_of(outline, 0), ring_of(outline, height)}, {sides_of(outline, 0)});
}

// A profile (radius, z) about the axis, n sides; `surfaces` by part of the profile.
Body lathe(const std::vector<dvec2>& profile, int n, const std::vector<std::int32_t>& surfaces) {
  std::vector<std::vector<dvec3>> rings;
  std::vector<std::vector<std::int32_t>> bands;
  for (const dvec2& p : profile) rings.push_back(ring_of(ellipse(n, p.x, p.x), p.y));
  for (const std::int32_t surface : surfaces) bands.emplace_back(n, surface);
  return body_of_rings(rings, bands);
}

// Several profiles in a row, each a smooth surface.
Body lathe(const std::vector<std::vector<dvec2>>& parts, int n) {
  std::vector<dvec2> profile{parts.front().front()};
  std::vector<std::int32_t> surfaces;
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (std::size_t i = 1; i < parts[p].size(); ++i) {
      profile.push_back(parts[p][i]);
      surfaces.push_back(static_cast<std::int32_t>(p));
    }
  return lathe(profile, n, surfaces);
}

// Of a circle about (x, y), from one angle to another in degrees from the horizontal.
std::vector<dvec2> arc(double x, double y, double radius, double from, double to, int steps) {
  std::vector<dvec2> places;
  for (int i = 0; i <= steps; ++i) {
    const double angle = (from + (to - from) * i / steps) * kDegree;
    places.emplace_back(x + radius * std::cos(angle), y + radius * std::sin(angle));
    if (std::abs(places.back().x) < 1e-12) places.back().x = 0;
  }
  return places;
}

void all_facets(Body& body) { body.surfaces.assign(body.mesh.face_count(), kFacet); }

Body of_mesh(PolygonMesh mesh, std::int32_t surface) {
  Body body{std::move(mesh), {}};
  body.surfaces.assign(body.mesh.face_count(), surface);
  return body;
}

// A ring of triangles between two outlines of any counts about the same middle, in one plane.
void add_ring(Body& body, const std::vector<std::int32_t>& outer,
              const std::vector<std::int32_t>& inner, std::int32_t surface, bool is_up) {
  const auto angle = [&](std::int32_t v, const dvec2& middle) {
    const dvec2 p = dvec2(body.mesh.positions[v]) - middle;
    return std::atan2(p.y, p.x);
  };
  dvec2 middle(0.0);
  for (const std::int32_t v : inner)
    middle += dvec2(body.mesh.positions[v]) / static_cast<double>(inner.size());
  // From the place on that is nearest to one direction.
  const auto sorted = [&](std::vector<std::int32_t> ring) {
    const auto first = std::ranges::min_element(
        ring, {}, [&](std::int32_t v) { return std::abs(angle(v, middle)); });
    std::rotate(ring.begin(), first, ring.end());
    return ring;
  };
  const std::vector<std::int32_t> a = sorted(outer), b = sorted(inner);
  std::size_t i = 0, j = 0;
  const auto apart = [&](std::int32_t v, std::int32_t w) {
    return glm::distance(body.mesh.positions[v], body.mesh.positions[w]);
  };
  const auto add = [&](std::array<std::int32_t, 3> face) {
    if (!is_up) std::swap(face[0], face[1]);
    body.mesh.add_face(face);
    body.surfaces.push_back(surface);
  };
  while (i < a.size() || j < b.size()) {
    const std::int32_t p = a[i % a.size()], q = b[j % b.size()];
    const std::int32_t next_p = a[(i + 1) % a.size()], next_q = b[(j + 1) % b.size()];
    // The shorter of both diagonals.
    const bool is_outer = j == b.size() || (i < a.size() && apart(next_p, q) < apart(p, next_q));
    if (is_outer) {
      add({p, next_p, q});
      ++i;
    } else {
      add({p, next_q, q});
      ++j;
    }
  }
}

// Places of an outline at a height, as numbers of new vertices.
std::vector<std::int32_t> add_outline(Body& body, const Outline2& outline, double z,
                                      double scale = 1) {
  std::vector<std::int32_t> ring;
  for (const dvec2& p : outline) {
    ring.push_back(body.mesh.vertex_count());
    body.mesh.positions.emplace_back(scale * p, z);
  }
  return ring;
}

void add_walls(Body& body, const std::vector<std::int32_t>& low,
               const std::vector<std::int32_t>& high, const std::vector<std::int32_t>& surfaces,
               bool is_out = true) {
  for (std::size_t i = 0; i < low.size(); ++i) {
    const std::size_t j = (i + 1) % low.size();
    std::array face{low[i], low[j], high[j], high[i]};
    if (!is_out) std::ranges::reverse(face);
    body.mesh.add_face(face);
    body.surfaces.push_back(surfaces[i]);
  }
}

void add_end(Body& body, std::vector<std::int32_t> ring, bool is_up) {
  if (!is_up) std::ranges::reverse(ring);
  body.mesh.add_face(ring);
  body.surfaces.push_back(kFacet);
}

Outline2 rectangle(double x, double y) {
  return {{-x / 2, -y / 2}, {x / 2, -y / 2}, {x / 2, y / 2}, {-x / 2, y / 2}};
}

// The surface of the sides over an even outline of n corners.
std::int32_t side_of_even(int n) { return n <= 6 ? kFacet : 0; }

// A frustum that rises from radius 1 to `top`, its sides leaning by `lean` degrees.
Body frustum(int n, double top, double lean) {
  const double apothem = std::cos(kFullTurn / 2 / n);
  const double height = (1 - top) * apothem / std::tan(lean * kDegree);
  return body_of_rings({ring_of(ellipse(n, 1, 1), 0), ring_of(ellipse(n, 1, 1), height, top)},
                       {std::vector<std::int32_t>(n, side_of_even(n))});
}

// Over a circle of radius 1, its sides leaning by `lean` degrees inwards.
Body pyramid(int n, double lean) {
  const double height = std::cos(kFullTurn / 2 / n) / std::tan(lean * kDegree);
  return lathe({{1, 0}, {0, height}}, n, {side_of_even(n)});
}

Outline2 rounded_rectangle(double x, double y, double radius, int steps) {
  Outline2 outline;
  const std::array<dvec2, 4> centres{dvec2(x / 2 - radius, y / 2 - radius),
                                     {radius - x / 2, y / 2 - radius},
                                     {radius - x / 2, radius - y / 2},
                                     {x / 2 - radius, radius - y / 2}};
  for (int k = 0; k < 4; ++k)
    for (const dvec2& p : arc(centres[k].x, centres[k].y, radius, 90 * k, 90 * (k + 1), steps))
      outline.push_back(p);
  return outline;
}

Outline2 stairs(int steps, double width, double rise) {
  Outline2 outline{{0, 0}, {steps * width, 0}};
  for (int i = 0; i < steps; ++i) {
    outline.emplace_back((steps - i) * width, (i + 1) * rise);
    outline.emplace_back((steps - i - 1) * width, (i + 1) * rise);
  }
  return outline;
}

Outline2 star(int spikes, double inner) {
  Outline2 outline;
  for (int i = 0; i < 2 * spikes; ++i) {
    const double r = i % 2 == 0 ? 1 : inner, angle = kFullTurn * i / (2 * spikes);
    outline.emplace_back(r * std::cos(angle), r * std::sin(angle));
  }
  return outline;
}

Outline2 gear_outline(int teeth, double depth) {
  Outline2 outline;
  for (int i = 0; i < teeth; ++i)
    for (const auto& [at, r] :
         {std::pair(0.0, 1 - depth), {0.25, 1.0}, {0.5, 1.0}, {0.75, 1 - depth}}) {
      const double angle = kFullTurn * (i + at) / teeth;
      outline.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
  return outline;
}

Body sheet(int columns, int rows, const std::function<dvec3(double, double)>& shape,
           const std::function<std::int32_t(int column)>& surface) {
  Body body;
  body.mesh = grid(columns, rows, shape);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) body.surfaces.push_back(surface(i));
  return body;
}

std::int32_t one(int) { return 0; }

// A round wire along a helix, in triangles: its quads are twisted.
Body coil(Lot& lot) {
  const int steps = lot.whole(10, 20), sides = lot.whole(8, 16);
  const double wire = lot.real(0.1, 0.2), pitch = lot.real(0.5, 1);
  Body body;
  const auto at = [&](int i, int j) { return i * sides + j % sides; };
  for (int i = 0; i <= 2 * steps; ++i) {
    const double turn = kFullTurn * i / steps;
    const dvec3 out(std::cos(turn), std::sin(turn), 0);
    const dvec3 along = glm::normalize(dvec3(-std::sin(turn), std::cos(turn), pitch / kFullTurn));
    const dvec3 up = glm::cross(out, along);
    for (int j = 0; j < sides; ++j) {
      const double angle = kFullTurn * j / sides;
      body.mesh.positions.push_back(out + dvec3(0, 0, pitch * i / steps) +
                                    wire * (std::cos(angle) * out + std::sin(angle) * up));
    }
  }
  const auto add = [&](const std::vector<std::int32_t>& face, std::int32_t surface) {
    body.mesh.add_face(face);
    body.surfaces.push_back(surface);
  };
  for (int i = 0; i < 2 * steps; ++i)
    for (int j = 0; j < sides; ++j) {
      add({at(i, j), at(i, j + 1), at(i + 1, j + 1)}, 0);
      add({at(i, j), at(i + 1, j + 1), at(i + 1, j)}, 0);
    }
  std::vector<std::int32_t> first, last;
  for (int j = 0; j < sides; ++j) {
    first.push_back(at(0, j));
    last.push_back(at(2 * steps, j));
  }
  std::ranges::reverse(first);
  add(first, kFacet);
  add(last, kFacet);
  return body;
}

std::vector<BodyFamily> make_known() {
  return {
      {"prism",
       [](Lot& lot) { return extruded_body(ellipse(lot.whole(3, 24), 1, 1), lot.ratio(0.1, 8)); }},
      {"box",
       [](Lot& lot) { return extruded_body(rectangle(lot.ratio(0.2, 5), lot.ratio(0.2, 5)), 1); }},
      {"frustum",
       [](Lot& lot) { return frustum(lot.whole(3, 20), lot.real(0.2, 0.9), lot.real(2, 45)); }},
      {"wedge",
       [](Lot& lot) {
         const double angle = lot.real(10, 120) * kDegree, length = lot.ratio(0.5, 2);
         Body body =
             extruded_body({{0, 0}, {1, 0}, {length * std::cos(angle), length * std::sin(angle)}},
                           lot.ratio(0.2, 4));
         all_facets(body);
         return body;
       }},
      {"L, U, T or cross",
       [](Lot& lot) {
         const double a = lot.ratio(0.2, 1), b = lot.ratio(0.2, 1), c = lot.ratio(0.2, 1),
                      d = lot.ratio(0.2, 1);
         Outline2 outline;
         switch (lot.whole(0, 3)) {
           case 0:
             outline = {{0, 0}, {a + b, 0}, {a + b, c}, {a, c}, {a, c + d}, {0, c + d}};
             break;
           case 1:
             outline = {{0, 0},     {a + b + c, 0}, {a + b + c, d + a}, {a + b, d + a},
                        {a + b, d}, {a, d},         {a, d + b},         {0, d + b}};
             break;
           case 2:
             outline = {{a, 0},     {a + b, 0}, {a + b, c}, {a + b + a, c}, {2 * a + b, c + d},
                        {0, c + d}, {0, c},     {a, c}};
             break;
           default:
             outline = {{a, 0},
                        {a + b, 0},
                        {a + b, c},
                        {2 * a + b, c},
                        {2 * a + b, c + d},
                        {a + b, c + d},
                        {a + b, 2 * c + d},
                        {a, 2 * c + d},
                        {a, c + d},
                        {0, c + d},
                        {0, c},
                        {a, c}};
         }
         return extruded_body(outline, lot.ratio(0.1, 3));
       }},
      {"stairs",
       [](Lot& lot) {
         return extruded_body(stairs(lot.whole(2, 8), lot.ratio(0.5, 2), 1), lot.ratio(0.5, 8));
       }},
      {"house",
       [](Lot& lot) {
         const double x = lot.ratio(1, 4), ridge = x / 2 * std::tan(lot.real(5, 60) * kDegree);
         Body body =
             extruded_body({{0, 0}, {x, 0}, {x, 1}, {x / 2, 1 + ridge}, {0, 1}}, lot.ratio(0.7, 4));
         all_facets(body);
         return body;
       }},
      {"chamfered box",
       [](Lot& lot) {
         const double x = lot.ratio(0.5, 2), y = lot.ratio(0.5, 2), c = lot.ratio(0.01, 0.06);
         const double rise = c * std::tan(lot.real(30, 60) * kDegree);
         Body body = body_of_rings({ring_of(rectangle(x, y), 0), ring_of(rectangle(x, y), 1 - rise),
                                    ring_of(rectangle(x - 2 * c, y - 2 * c), 1)},
                                   {{0, 1, 2, 3}, {0, 1, 2, 3}});
         all_facets(body);
         return body;
       }},
      {"pipe",
       [](Lot& lot) {
         const int n = lot.whole(7, 32);
         const double inner = lot.real(0.3, 0.95);
         Body body;
         body.mesh = hollow(ellipse(n, 1, 1), ellipse(n, inner, inner), lot.ratio(0.1, 5));
         for (int i = 0; i < n; ++i)
           for (const std::int32_t surface : {0, 1, 2, 3}) body.surfaces.push_back(surface);
         return body;
       }},
      {"cone",
       [](Lot& lot) {
         return lathe({{{1, 0}, {0, lot.ratio(0.7, 4)}}}, lot.whole(7, 40));
       }},
      {"slot",
       [](Lot& lot) {
         const int steps = lot.whole(4, 10);
         const double length = lot.ratio(0.3, 4);
         Outline2 outline;
         for (const int side : {0, 1})
           for (const dvec2& p :
                arc(side ? -length : length, 0, 1, side ? 90 : -90, side ? 270 : 90, steps))
             outline.push_back(p);
         return extruded_body(outline, lot.ratio(0.1, 3));
       }},
      {"rounded box",
       [](Lot& lot) {
         return extruded_body(rounded_rectangle(lot.ratio(1, 3), lot.ratio(1, 3),
                                                lot.real(0.05, 0.4), lot.whole(2, 8)),
                              lot.ratio(0.1, 3));
       }},
      {"chamfered slot",
       [](Lot& lot) {
         // Flat ends between narrow chamfers, straight sides and round ones.
         const int steps = lot.whole(6, 12);
         const double c = lot.ratio(0.05, 0.3), length = lot.ratio(0.3, 4),
                      height = lot.ratio(0.3, 3);
         const auto ring = [&](double radius, double z) {
           Outline2 outline;
           for (const int side : {0, 1})
             for (const dvec2& p :
                  arc(side ? -length : length, 0, radius, side ? 90 : -90, side ? 270 : 90, steps))
               outline.push_back(p);
           return ring_of(outline, z);
         };
         const auto band = [&](std::int32_t surface) {
           return std::vector<std::int32_t>(2 * static_cast<std::size_t>(steps) + 2, surface);
         };
         return body_of_rings(
             {ring(1 - c, 0), ring(1, c), ring(1, height + c), ring(1 - c, height + 2 * c)},
             {band(0), band(1), band(2)});
       }},
      {"chamfered shaft",
       [](Lot& lot) {
         const double c = lot.ratio(0.03, 0.2), height = lot.ratio(0.2, 4);
         return lathe({{{1 - c, 0}, {1, c}},
                       {{1, c}, {1, height + c}},
                       {{1, height + c}, {1 - c, height + 2 * c}}},
                      lot.whole(12, 40));
       }},
      {"coil", [](Lot& lot) { return coil(lot); }},
      {"gear",
       [](Lot& lot) {
         Body body = extruded_body(gear_outline(lot.whole(12, 24), lot.real(0.15, 0.25)),
                                   lot.ratio(0.1, 1));
         all_facets(body);
         return body;
       }},
      {"star",
       [](Lot& lot) {
         const int spikes = lot.whole(4, 8);
         Body body = extruded_body(star(spikes, lot.real(0.3, 0.6)), lot.ratio(0.1, 1));
         all_facets(body);
         return body;
       }},
      {"boss",
       [](Lot& lot) {
         const int n = lot.whole(8, 32);
         Body body;
         const Outline2 plate = rectangle(lot.real(2.5, 5), lot.real(2.5, 5));
         const Outline2 round = ellipse(n, 1, 1);
         const auto low = add_outline(body, plate, 0), high = add_outline(body, plate, 1),
                    foot = add_outline(body, round, 1),
                    top = add_outline(body, round, 1 + lot.ratio(0.1, 2));
         add_end(body, low, false);
         add_walls(body, low, high, {1, 2, 3, 4});
         add_ring(body, high, foot, 5, true);
         add_walls(body, foot, top, std::vector<std::int32_t>(n, 6));
         add_end(body, top, true);
         return body;
       }},
      {"bored box",
       [](Lot& lot) {
         const int n = lot.whole(7, 32);
         Body body;
         const Outline2 plate = rectangle(lot.real(2.5, 5), lot.real(2.5, 5));
         const Outline2 round = ellipse(n, 1, 1);
         const double height = lot.ratio(0.2, 3);
         const auto low = add_outline(body, plate, 0), high = add_outline(body, plate, height),
                    under = add_outline(body, round, 0), over = add_outline(body, round, height);
         add_walls(body, low, high, {1, 2, 3, 4});
         add_ring(body, low, under, 5, false);
         add_ring(body, high, over, 6, true);
         add_walls(body, under, over, std::vector<std::int32_t>(n, 7), false);
         return body;
       }},
      {"sphere",
       [](Lot& lot) {
         const int across = lot.whole(4, 12);
         return lathe({arc(0, 0, 1, -90, 90, across)}, lot.whole(7, 2 * across));
       }},
      {"icosphere", [](Lot& lot) { return of_mesh(icosphere(lot.whole(0, 3)), 0); }},
      {"ellipsoid",
       [](Lot& lot) {
         Body body = of_mesh(icosphere(lot.whole(1, 3)), 0);
         const dvec3 axes(lot.ratio(0.7, 1.4), lot.ratio(0.7, 1.4), 1);
         for (dvec3& p : body.mesh.positions) p *= axes;
         return body;
       }},
      {"torus",
       [](Lot& lot) {
         const int n = lot.whole(10, 16);
         return of_mesh(torus(lot.whole(n, 3 * n), n, 1, lot.real(0.2, 0.5)), 0);
       }},
      {"capsule",
       [](Lot& lot) {
         const double length = lot.ratio(0.3, 4);
         const int steps = lot.whole(3, 6);
         std::vector<dvec2> profile = arc(0, 0, 1, -90, 0, steps);
         for (const dvec2& p : arc(0, length, 1, 0, 90, steps)) profile.push_back(p);
         return lathe({profile}, lot.whole(8, 32));
       }},
      {"dome",
       [](Lot& lot) { return lathe({arc(0, 0, 1, 0, 90, lot.whole(3, 8))}, lot.whole(8, 32)); }},
      {"lens",
       [](Lot& lot) {
         const double angle = lot.real(40, 70);
         const int steps = lot.whole(3, 6);
         std::vector<dvec2> low =
                                arc(0, std::sin((90 - angle) * kDegree), 1, -90, angle - 90, steps),
                            high =
                                arc(0, -std::sin((90 - angle) * kDegree), 1, 90 - angle, 90, steps);
         return lathe({low, high}, lot.whole(8, 32));
       }},
      {"chamfered cylinder",
       [](Lot& lot) {
         const double c = lot.ratio(0.02, 0.15), rise = c * std::tan(lot.real(38, 52) * kDegree);
         return lathe({{{1, 0}, {1, 1}}, {{1, 1}, {1 - c, 1 + rise}}}, lot.whole(10, 40));
       }},
      {"folded sheet",
       [](Lot& lot) {
         const int columns = 2 * lot.whole(1, 4), rows = lot.whole(1, 5);
         const double slope = std::tan(lot.real(2, 40) * kDegree);
         return sheet(
             columns, rows,
             [=](double x, double y) { return dvec3(x, y, slope * std::abs(x - columns / 2)); },
             [=](int i) { return i < columns / 2 ? 0 : 1; });
       }},
      {"wavy sheet",
       [](Lot& lot) {
         const double height = lot.real(0.05, 0.5), wave = lot.real(5, 9);
         const int columns = lot.whole(6, 20), rows = lot.whole(6, 20);
         return sheet(
             columns, rows,
             [=](double x, double y) {
               return dvec3(
                   x, y, height * std::sin(kFullTurn * x / wave) * std::cos(kFullTurn * y / wave));
             },
             one);
       }},
      {"goblet",
       [](Lot& lot) {
         std::vector<dvec2> profile;
         const int steps = lot.whole(8, 20);
         const double waist = lot.real(0.1, 0.3), height = lot.real(3, 5);
         for (int i = 0; i <= steps; ++i)
           profile.emplace_back(1 - waist + waist * std::cos(kFullTurn * i / steps),
                                height * i / steps);
         return lathe({profile}, lot.whole(8, 40));
       }},
      {"oval",
       [](Lot& lot) {
         return extruded_body(ellipse(2 * lot.whole(5, 16), lot.real(1, 1.5), 1),
                              lot.ratio(0.2, 3));
       }},
      {"half disc",
       [](Lot& lot) {
         return extruded_body(arc(0, 0, 1, 0, 180, lot.whole(5, 16)), lot.ratio(0.1, 3));
       }},
      {"pyramid", [](Lot& lot) { return pyramid(lot.whole(3, 10), lot.real(2, 50)); }},
  };
}

// A plate with a hole that goes through; walls of the plate, of the hole.
Body bored(const Outline2& plate, const Outline2& hole, double height) {
  Body body;
  const auto low = add_outline(body, plate, 0), high = add_outline(body, plate, height),
             under = add_outline(body, hole, 0), over = add_outline(body, hole, height);
  add_walls(body, low, high, sides_of(plate, 10));
  add_ring(body, low, under, 0, false);
  add_ring(body, high, over, 1, true);
  add_walls(body, under, over, sides_of(hole, 100), false);
  return body;
}

// A body on another, both over outlines.
Body on_top(const Outline2& lower, double height, const Outline2& upper, double more) {
  Body body;
  const auto low = add_outline(body, lower, 0), high = add_outline(body, lower, height),
             foot = add_outline(body, upper, height), top = add_outline(body, upper, height + more);
  add_end(body, low, false);
  add_walls(body, low, high, sides_of(lower, 10));
  add_ring(body, high, foot, 0, true);
  add_walls(body, foot, top, sides_of(upper, 100));
  add_end(body, top, true);
  return body;
}

Outline2 superellipse(int n, double exponent) {
  Outline2 outline;
  for (int i = 0; i < n; ++i) {
    const double c = std::cos(kFullTurn * i / n), s = std::sin(kFullTurn * i / n);
    const double r =
        std::pow(std::pow(std::abs(c), exponent) + std::pow(std::abs(s), exponent), -1 / exponent);
    outline.emplace_back(r * c, r * s);
  }
  return outline;
}

Body facets(Body body) {
  all_facets(body);
  return body;
}

std::vector<BodyFamily> make_held_out() {
  return {
      {"nut",
       [](Lot& lot) {
         return bored(ellipse(6, 1, 1), ellipse(lot.whole(8, 40), 0.5, 0.5), lot.ratio(0.2, 2));
       }},
      {"bolt",
       [](Lot& lot) {
         return on_top(ellipse(6, 1, 1), lot.ratio(0.3, 1), ellipse(lot.whole(8, 32), 0.6, 0.6),
                       lot.ratio(0.5, 6));
       }},
      {"chamfered hexagon",
       [](Lot& lot) {
         const double c = lot.ratio(0.02, 0.12), rise = c * std::tan(lot.real(35, 55) * kDegree);
         const Outline2 six = ellipse(6, 1, 1);
         const std::vector<std::int32_t> sides(6, 0);
         return facets(body_of_rings({ring_of(six, 0, 1 - c), ring_of(six, rise), ring_of(six, 1),
                                      ring_of(six, 1 + rise, 1 - c)},
                                     {sides, sides, sides}));
       }},
      {"I or Z",
       [](Lot& lot) {
         const double a = lot.ratio(0.2, 0.6), b = lot.ratio(0.2, 1), c = lot.ratio(0.5, 2);
         const Outline2 i{{0, 0},
                          {2 * b + a, 0},
                          {2 * b + a, a},
                          {b + a, a},
                          {b + a, a + c},
                          {2 * b + a, a + c},
                          {2 * b + a, 2 * a + c},
                          {0, 2 * a + c},
                          {0, a + c},
                          {b, a + c},
                          {b, a},
                          {0, a}};
         const Outline2 z{{0, 0},     {b + a, 0}, {b + a, c}, {2 * b + a, c}, {2 * b + a, c + a},
                          {b, c + a}, {b, a},     {0, a}};
         return extruded_body(lot.chance(0.5) ? i : z, lot.ratio(0.2, 5));
       }},
      {"dovetail",
       [](Lot& lot) {
         const double lean = lot.real(0.1, 0.5);
         return facets(extruded_body(
             {{0, 0}, {3, 0}, {3, 1}, {2, 1}, {2 + lean, 2}, {1 - lean, 2}, {1, 1}, {0, 1}},
             lot.ratio(0.5, 4)));
       }},
      {"bottle",
       [](Lot& lot) {
         const double neck = lot.real(0.25, 0.5), height = lot.ratio(0.5, 3);
         const int steps = lot.whole(3, 6);
         std::vector<dvec2> side{{1, 0}};
         const double r = (1 - neck) / 2;
         for (const dvec2& p : arc(1 - r, height, r, 0, 90, steps)) side.push_back(p);
         std::vector<dvec2> shoulder = arc(1 - r, height + 2 * r, r, 270, 180, steps);
         side.insert(side.end(), shoulder.begin() + 1, shoulder.end());
         side.emplace_back(neck, height + 2 * r + lot.ratio(0.2, 1));
         return lathe({side}, lot.whole(10, 32));
       }},
      {"tower",
       [](Lot& lot) {
         const int n = lot.whole(3, 6);
         return facets(lathe({{1, 0}, {1, lot.ratio(0.5, 4)}, {0, lot.real(5, 8)}}, n, {0, 1}));
       }},
      {"round tower",
       [](Lot& lot) {
         const double height = lot.ratio(0.5, 4);
         return lathe({{{1, 0}, {1, height}}, {{1, height}, {0, height + lot.real(0.4, 1)}}},
                      lot.whole(9, 40));
       }},
      {"mushroom",
       [](Lot& lot) {
         const double r = lot.real(0.2, 0.7), height = lot.ratio(0.3, 3);
         return lathe({{{r, 0}, {r, height}},
                       {{r, height}, {1, height}},
                       arc(0, height, 1, 0, 90, lot.whole(3, 8))},
                      lot.whole(8, 32));
       }},
      {"spool",
       [](Lot& lot) {
         const double a = lot.ratio(0.1, 0.5), r = lot.real(0.3, 0.8);
         return lathe({{{1, 0}, {1, a}},
                       {{1, a}, {r, a}},
                       {{r, a}, {r, 1 + a}},
                       {{r, 1 + a}, {1, 1 + a}},
                       {{1, 1 + a}, {1, 1 + 2 * a}}},
                      lot.whole(8, 40));
       }},
      {"castle",
       [](Lot& lot) {
         const int teeth = lot.whole(3, 8);
         Outline2 outline{{0, 0}, {2.0 * teeth - 1, 0}};
         const double depth = lot.ratio(0.3, 2);
         for (int i = teeth - 1; i >= 0; --i) {
           outline.emplace_back(2 * i + 1, 1 + depth);
           outline.emplace_back(2 * i, 1 + depth);
           if (i > 0) {
             outline.emplace_back(2 * i, 1);
             outline.emplace_back(2 * i - 1, 1);
           }
         }
         return extruded_body(outline, lot.ratio(0.3, 4));
       }},
      {"groove",
       [](Lot& lot) {
         const double width = lot.real(0.3, 1),
                      depth = width / 2 * std::tan(lot.real(20, 60) * kDegree);
         return facets(extruded_body({{0, 0},
                                      {3, 0},
                                      {3, 1.5},
                                      {1.5 + width / 2, 1.5},
                                      {1.5, 1.5 - std::min(depth, 1.2)},
                                      {1.5 - width / 2, 1.5},
                                      {0, 1.5}},
                                     lot.ratio(0.3, 4)));
       }},
      {"sheared box",
       [](Lot& lot) {
         Body body = extruded_body(rectangle(lot.ratio(0.5, 2), lot.ratio(0.5, 2)), 1);
         const double a = lot.real(-0.8, 0.8), b = lot.real(-0.8, 0.8);
         for (dvec3& p : body.mesh.positions) p += p.z * dvec3(a, b, 0);
         return facets(body);
       }},
      {"superellipse",
       [](Lot& lot) {
         return extruded_body(superellipse(4 * lot.whole(6, 12), lot.real(2, 3)),
                              lot.ratio(0.1, 3));
       }},
      {"egg",
       [](Lot& lot) {
         std::vector<dvec2> profile = arc(0, 0, 1, -90, 0, lot.whole(3, 6));
         const double high = lot.real(1, 1.8);
         const std::vector<dvec2> upper = arc(0, 0, 1, 0, 90, lot.whole(4, 8));
         for (std::size_t i = 1; i < upper.size(); ++i)
           profile.emplace_back(upper[i].x, high * upper[i].y);
         return lathe({profile}, lot.whole(8, 32));
       }},
      {"vesica",
       [](Lot& lot) {
         // Two arcs that meet in corners of 90 degrees and more.
         const double half = lot.real(30, 55);
         const int steps = lot.whole(5, 12);
         Outline2 outline;
         for (const int side : {0, 1}) {
           const double middle = std::cos(half * kDegree) * (side ? 1 : -1);
           const std::vector<dvec2> round =
               arc(middle, 0, 1, side ? 180 - half : -half, side ? 180 + half : half, steps);
           outline.insert(outline.end(), round.begin(), round.end() - 1);
         }
         return extruded_body(outline, lot.ratio(0.2, 2));
       }},
      {"bowl of a sheet",
       [](Lot& lot) {
         const double a = lot.real(-0.04, 0.04), b = lot.real(-0.04, 0.04),
                      c = lot.real(-0.04, 0.04);
         return sheet(
             lot.whole(5, 14), lot.whole(5, 14),
             [=](double x, double y) { return dvec3(x, y, a * x * x + b * x * y + c * y * y); },
             one);
       }},
      {"tray",
       [](Lot& lot) {
         const double x = lot.ratio(0.7, 2), y = lot.ratio(0.7, 2), wall = lot.real(0.05, 0.2),
                      draft = lot.real(0, 0.08), floor = lot.real(0.1, 0.4);
         Body body;
         const auto low = add_outline(body, rectangle(x - 2 * draft, y - 2 * draft), 0),
                    high = add_outline(body, rectangle(x, y), 1),
                    rim = add_outline(body, rectangle(x - 2 * wall, y - 2 * wall), 1),
                    deep = add_outline(
                        body, rectangle(x - 2 * wall - 2 * draft, y - 2 * wall - 2 * draft), floor);
         add_end(body, low, false);
         add_walls(body, low, high, {0, 1, 2, 3});
         add_ring(body, high, rim, 4, true);
         add_walls(body, deep, rim, {5, 6, 7, 8}, false);
         add_end(body, deep, true);
         return body;
       }},
      {"plate with a slot",
       [](Lot& lot) {
         const double length = lot.ratio(0.3, 1.5);
         Outline2 hole;
         const int steps = lot.whole(4, 10);
         for (const int side : {0, 1})
           for (const dvec2& p :
                arc(side ? -length : length, 0, 0.5, side ? 90 : -90, side ? 270 : 90, steps))
             hole.push_back(p);
         return bored(rectangle(2 * length + lot.real(1.5, 3), lot.real(1.5, 3)), hole,
                      lot.ratio(0.2, 2));
       }},
      {"stepped shaft",
       [](Lot& lot) {
         const double r = lot.real(0.4, 0.9), a = lot.ratio(0.3, 3);
         return lathe({{{1, 0}, {1, 1}}, {{1, 1}, {r, 1}}, {{r, 1}, {r, 1 + a}}}, lot.whole(8, 48));
       }},
      {"block with a round edge",
       [](Lot& lot) {
         Outline2 outline{{0, 0}, {2, 0}};
         const double r = lot.real(0.2, 1);
         for (const dvec2& p : arc(2 - r, 1.5 - r, r, 0, 90, lot.whole(3, 10)))
           outline.push_back(p);
         outline.emplace_back(0, 1.5);
         return extruded_body(outline, lot.ratio(0.2, 3));
       }},
      {"double pyramid",
       [](Lot& lot) {
         const int n = lot.whole(3, 4);
         return facets(lathe({{0, -lot.ratio(1, 2)}, {1, 0}, {0, lot.ratio(1, 2)}}, n, {0, 1}));
       }},
  };
}

std::vector<BodyFamily> make_weak() {
  return {
      {"hip roof",
       [](Lot& lot) {
         const double x = lot.ratio(1.3, 4), rise = std::tan(lot.real(12, 50) * kDegree) / 2;
         Body body;
         const auto low = add_outline(body, rectangle(x, 1), 0),
                    high = add_outline(body, rectangle(x, 1), 0.7);
         add_end(body, low, false);
         add_walls(body, low, high, {0, 1, 2, 3});
         const std::int32_t left = body.mesh.vertex_count(), right = left + 1;
         body.mesh.positions.emplace_back((1 - x) / 2, 0, 0.7 + rise);
         body.mesh.positions.emplace_back((x - 1) / 2, 0, 0.7 + rise);
         body.mesh.add_face(std::array{high[0], high[1], right, left});
         body.mesh.add_face(std::array{high[1], high[2], right});
         body.mesh.add_face(std::array{high[2], high[3], left, right});
         body.mesh.add_face(std::array{high[3], high[0], left});
         all_facets(body);
         return body;
       }},
  };
}

}  // namespace

int Lot::whole(int least, int most) {
  return least + static_cast<int>(random_() % static_cast<std::uint32_t>(most - least + 1));
}

double Lot::real(double least, double most) {
  return least + (most - least) * (random_() / 4294967296.0);
}

double Lot::ratio(double least, double most) {
  return std::exp(real(std::log(least), std::log(most)));
}

const std::vector<BodyFamily>& known_families() {
  static const std::vector<BodyFamily> families = make_known();
  return families;
}

const std::vector<BodyFamily>& held_out_families() {
  static const std::vector<BodyFamily> families = make_held_out();
  return families;
}

const std::vector<BodyFamily>& weak_families() {
  static const std::vector<BodyFamily> families = make_weak();
  return families;
}

}  // namespace planish::test
