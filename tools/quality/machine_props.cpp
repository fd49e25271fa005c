// Parts of machines and tools. Lengths are in what suits the thing; z is up.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "quality/irregular_shapes.h"
#include "quality/prop_maker.h"
#include "quality/prop_shapes.h"

namespace planish::quality {

namespace {

using glm::dvec2;
using glm::dvec3;

// A ring about the z axis of a rectangular section with small chamfers.
PolygonMesh collar(std::int32_t n, double inner, double outer, double height, double chamfer,
                   std::int32_t segments, const Cut& cut) {
  return lathe(n,
               {{inner + chamfer, 0},
                {outer - chamfer, 0},
                {outer, chamfer},
                {outer, height - chamfer},
                {outer - chamfer, height},
                {inner + chamfer, height},
                {inner, height - chamfer},
                {inner, chamfer}},
               segments, cut, true);
}

// Chamfers of a solid of that height, at both ends.
Knots chamfered(double height, double chamfer) {
  return {{chamfer, 0}, {0, chamfer}, {0, height - chamfer}, {chamfer, height}};
}

// The same, rounded.
Knots rounded_ends(double height, double radius, std::int32_t steps) {
  return {{radius, 0, -90, steps}, {0, radius}, {0, height - radius, -90, steps}, {radius, height}};
}

// Long way along x, in the plane.
Knots slot(double length, double width, const dvec2& centre, bool is_hole, std::int32_t steps) {
  const double a = (length - width) / 2, b = width / 2;
  const dvec2 c = centre;
  if (is_hole)
    return {{c.x + a, c.y + b, -180, steps},
            {c.x + a, c.y - b},
            {c.x - a, c.y - b, -180, steps},
            {c.x - a, c.y + b}};
  return {{c.x + a, c.y - b, 180, steps},
          {c.x + a, c.y + b},
          {c.x - a, c.y + b, 180, steps},
          {c.x - a, c.y - b}};
}

std::vector<Knots> bores_around(std::int32_t count, double distance, double radius,
                                std::int32_t segments) {
  std::vector<Knots> bores;
  for (std::int32_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    bores.push_back(bore(segments, radius, distance * dvec2(std::cos(angle), std::sin(angle))));
  }
  return bores;
}

// Straight flanks between arcs at the tips and roots, so round that each takes one turn of its own.
Knots toothed(std::int32_t teeth, double root, double tip, std::int32_t steps) {
  Knots outline;
  const double pitch = 360.0 / teeth;
  for (std::int32_t i = 0; i < teeth; ++i)
    for (const auto& [part, radius, turn] :
         {std::array{0.0, root, 0.35}, {0.35, root, 0.0}, {0.5, tip, 0.35}, {0.85, tip, 0.0}}) {
      const double angle = (i + part) * pitch * std::numbers::pi / 180;
      outline.push_back({radius * std::cos(angle), radius * std::sin(angle), turn * pitch, steps});
    }
  return outline;
}

PolygonMesh cog_wheel(std::int32_t n) {
  return joined({solid(n, toothed(12, 0.8, 1, 2), chamfered(0.3, 0.03), kCadCut, {bore(16, 0.25)}),
                 placed(collar(n, 0.32, 0.5, 0.5, 0.03, 16, kGameCut), {0, 0, -0.1})});
}

PolygonMesh wrench(std::int32_t n) {
  // The open jaw, the shaft, and a head with a hexagonal hole.
  const Knots outline =
      "-0.3 0.42, 0.15 0.22, 0.15 -0.22, -0.3 -0.42, -0.2 -0.55 @110/4, 0.55 -0.2, 2.4 -0.15 "
      "@-40/2, 2.55 -0.3 @260/8, 2.55 0.3 @-40/2, 2.4 0.15, 0.55 0.2 @110/4, -0.2 0.55";
  Knots hole = even_polygon(6, 0.22);
  std::reverse(hole.begin(), hole.end());
  for (Knot& knot : hole) knot.x += 2.8;
  return solid(n, outline, chamfered(0.2, 0.02), kCadCut, {hole});
}

PolygonMesh screw_driver(std::int32_t n) {
  return joined(
      {lathe(n,
             "0 0 @90/3, 0.22 0.22, 0.24 0.5 ~, 0.25 1 ~, 0.16 1.4 ~, 0.2 1.6, 0.14 1.66, 0 1.66",
             10, kGameCut),
       lathe(n, "0 1.6, 0.06 1.6, 0.06 3, 0 3", 8, kGameCut),
       loft(1, rectangle(0.1, 0.1), {{2.97, {0.7, 0.7}}, {3.15, {1.8, 0.8}}, {3.35, {1.5, 0.25}}},
            false, kGameCut)});
}

PolygonMesh propeller(std::int32_t n) {
  const Knots section = "0.5 0 ~, 0.3 0.12 ~, 0 0.16 ~, -0.35 0.1 ~, -0.5 0";
  const PolygonMesh blade = loft(n, section,
                                 {{0.1, {0.35, 0.6}, {0, 0}, 60},
                                  {0.5, {0.6, 0.6}, {0, 0}, 40},
                                  {0.9, {0.8, 0.5}, {0, 0}, 28},
                                  {1.3, {0.7, 0.4}, {0, 0}, 20},
                                  {1.6, {0.3, 0.25}, {0, 0}, 16}},
                                 true, kUnevenCut);
  return joined({lathe(n, "0 -0.25, 0.22 -0.25, 0.24 0.2 ~, 0.2 0.4 ~, 0 0.6", 12, kGameCut),
                 around_axis(placed(blade, {0, 0, 0}, {0, 90, 0}), 3)});
}

PolygonMesh wheel_with_spokes(std::int32_t n) {
  const PolygonMesh spoke =
      placed(lathe(n, "0 0, 0.07 0, 0.05 0.75, 0 0.75", 8, kGameCut), {0.12, 0, 0}, {0, 90, 0});
  return joined(
      {lathe(n, "0.8 -0.1, 1 -0.1 @180/4, 1 0.1, 0.8 0.1", 20, kGameCut, true),
       lathe(n, "0 -0.16, 0.2 -0.16, 0.22 -0.14, 0.22 0.14, 0.2 0.16, 0 0.16", 12, kGameCut),
       around_axis(spoke, 6)});
}

PolygonMesh hinge(std::int32_t n) {
  const std::vector<Knots> holes{bore(10, 0.09, {0.7, 0.3}), bore(10, 0.09, {0.7, 1.2})};
  const PolygonMesh side =
      placed(solid(n, "0.14 0, 1 0, 1 1.5, 0.14 1.5", chamfered(0.1, 0.02), kCadCut, holes),
             {0, 0, -0.05});
  const PolygonMesh knuckle =
      placed(lathe(n, "0 0, 0.16 0, 0.18 0.02, 0.18 0.45, 0.16 0.47, 0 0.47", 12, kCadCut),
             {0, 0, 0}, {-90, 0, 0});
  return joined({side, placed(side, {0, 1.5, 0}, {0, 0, 180}),
                 copied(knuckle, {{0, 0.01, 0}, {0, 0.515, 0}, {0, 1.02, 0}})});
}

PolygonMesh bearing(std::int32_t n) {
  const PolygonMesh ball = placed(lathe(n, "0 -0.14 @180/5, 0 0.14", 8, kStripCut), {0.75, 0, 0.2});
  return joined(
      {lathe(n, "0.4 0, 0.6 0, 0.62 0.02, 0.62 0.08 @-90/3, 0.62 0.32, 0.62 0.38, 0.6 0.4, 0.4 0.4",
             20, kStripCut, true),
       lathe(n, "0.92 0, 1.1 0, 1.1 0.4, 0.92 0.4, 0.9 0.38, 0.9 0.02", 20, kStripCut, true),
       around_axis(ball, 7)});
}

// Legs along x and z; two bores through the lower one, cut as one profile with the fillet.
PolygonMesh bracket(std::int32_t n) {
  const Knots bend = "0 0, 2 0, 2 0.3, 0.7 0.3 @-90/4, 0.3 0.7, 0.3 1.8 @180/8, 0 1.8";
  const Knots flange = "0.8 0.2, 1.9 0.2, 1.9 1.1, 0.8 1.1";
  return joined(
      {solid(n, bend, "0 0, 0 0.6", kCadCut, {bore(12, 0.08, {1.2, 0.15})}),
       placed(solid(n, flange, chamfered(0.2, 0.04), kCadCut, {bore(12, 0.15, {1.3, 0.8})}),
              {0, 0, 0.2}, {0, 0, 0})});
}

PolygonMesh elbow(std::int32_t n) {
  const PolygonMesh flange = lathe(n, "0.36 0, 0.62 0, 0.62 0.12, 0.36 0.12", 16, kGameCut, true);
  return joined({tube(n, "1 0 @0/1, 1 0.3 @90/5, 0 1.3, -0.4 1.3", 0.4, 16, kGameCut, 0.28),
                 placed(flange, {1, 0, 0.02}), placed(flange, {-0.38, 0, 1.3}, {0, 90, 0})});
}

}  // namespace

std::vector<Prop> machine_props() {
  return {
      {"spur gear", 16,
       [](auto n) {
         Knots teeth;
         for (int i = 0; i < 14; ++i)
           for (const auto& [part, r] :
                {std::pair(0.0, 1.0), {0.15, 1.25}, {0.4, 1.25}, {0.55, 1.0}}) {
             const double angle = 2 * std::numbers::pi * (i + part) / 14;
             teeth.push_back({r * std::cos(angle), r * std::sin(angle)});
           }
         return solid(n, teeth, "0 0, 0 0.4", kCadCut, {bore(16, 0.35)});
       }},
      {"cog wheel", 16, cog_wheel},
      {"bolt", 16,
       [](auto n) {
         return joined(
             {solid(n, even_polygon(6, 0.5), "0 0, 0 0.3, 0.05 0.35", kGameCut),
              lathe(n, "0 -1.55, 0.2 -1.55, 0.25 -1.5, 0.25 0.05, 0 0.05", 16, kGameCut)});
       }},
      {"nut", 16,
       [](auto n) {
         return solid(n, even_polygon(6, 0.5), chamfered(0.4, 0.04), kCadCut, {bore(16, 0.25)});
       }},
      {"screw driver", 10, screw_driver},
      {"wrench", 16, wrench},
      {"spring", 16, [](auto n) { return coil(n, 3, 0.4, 0.6, 12, 0.1, 8, kGameCut); }},
      {"funnel", 16,
       [](auto n) {
         return lathe(n, "0.12 0, 0.2 0, 0.22 0.6, 0.9 1.3, 0.9 1.4, 0.8 1.4, 0.14 0.68", 16,
                      kGameCut, true);
       }},
      {"bell", 16,
       [](auto n) {
         return joined({lathe(n,
                              "0 0.9 ~, 0.3 0.85 ~, 0.42 0.6 ~, 0.5 0.3 ~, 0.65 0, 0.8 0, 0.66 0.3 "
                              "~, 0.56 0.65 ~, 0.42 0.95 ~, 0 1.1",
                              16, kGameCut),
                        placed(lathe(n, "0 -0.12 @180/4, 0 0.12", 8, kGameCut), {0, 0, 0.1})});
       }},
      {"dumbbell", 12,
       [](auto n) {
         const Knots disc_side = "0 0, 0.4 0, 0.45 0.05, 0.45 0.3, 0.4 0.35, 0 0.35";
         return joined({lathe(n, "0 0.1, 0.1 0.1, 0.1 1.9, 0 1.9", 10, kFanCut),
                        lathe(n, disc_side, 12, kFanCut),
                        placed(lathe(n, disc_side, 12, kFanCut), {0, 0, 1.65})});
       }},
      {"tyre", 24,
       [](auto n) {
         return lathe(n,
                      "0.6 -0.2, 0.7 -0.25, 0.86 -0.25 @90/3, 1 -0.11, 1 0.11 @90/3, 0.86 0.25, "
                      "0.7 0.25, 0.6 0.2",
                      24, kGameCut, true);
       }},
      {"wheel with spokes", 20, wheel_with_spokes},
      {"propeller", 12, propeller},
      {"bracket", 16, bracket},
      {"flange", 24,
       [](auto n) {
         return joined({solid(n, disc(24, 1), chamfered(0.25, 0.03), kCadCut,
                              [] {
                                std::vector<Knots> holes = bores_around(6, 0.75, 0.12, 10);
                                holes.push_back(bore(20, 0.4));
                                return holes;
                              }()),
                        placed(collar(n, 0.44, 0.58, 0.9, 0.02, 20, kCadCut), {0, 0, 0.1})});
       }},
      {"pipe elbow", 16, elbow},
      {"tee duct", 12,
       [](auto n) {
         const Knots outer =
             "-1.5 -0.5, 1.5 -0.5, 1.5 0.5, 0.8 0.5 @-90/3, 0.5 0.8, 0.5 1.6, -0.5 1.6, -0.5 0.8 "
             "@-90/3, -0.8 0.5, -1.5 0.5";
         Knots inner =
             "-1.35 0.35, -0.8 0.35 @90/3, -0.35 0.8, -0.35 1.45, 0.35 1.45, 0.35 0.8 @90/3, 0.8 "
             "0.35, 1.35 0.35, 1.35 -0.35, -1.35 -0.35";
         return solid(n, outer, "0 0, 0 0.8", kCadCut, {inner});
       }},
      {"housing with chamfers", 12,
       [](auto n) {
         return solid(n, rounded_rectangle(2, 1.4, 0.25, 3),
                      "0.1 0, 0 0.1, 0 0.8, 0.04 0.84, 0.15 0.84, 0.15 0.15", kFanCut);
       }},
      {"plate with slots", 16,
       [](auto n) {
         return solid(n, rounded_rectangle(3, 1.6, 0.2, 3), "0 0, 0 0.2", kCadCut,
                      {slot(1.2, 0.3, {0, 0.35}, true, 6), slot(1.2, 0.3, {0, -0.35}, true, 6),
                       bore(12, 0.15, {1.2, 0}), bore(12, 0.15, {-1.2, 0})});
       }},
      {"drilled block", 16,
       [](auto n) {
         return solid(n, rectangle(2, 1.4), chamfered(1, 0.08), kCadCut,
                      {bore(16, 0.3, {0.45, 0}), bore(12, 0.2, {-0.5, 0.2})});
       }},
      {"casting", 16,
       [](auto n) {
         const Knots outline =
             "-1 -0.6 @90/3, -0.6 -1, 1.2 -1 @90/3, 1.6 -0.6, 1.6 -0.4 @90/3, 1.2 0, 0.4 0 @-90/3, "
             "0 0.4, 0 1 @180/6, -1 1";
         return solid(n, outline, rounded_ends(0.7, 0.15, 2), kCadCut,
                      {bore(12, 0.15, {1, -0.5}), bore(12, 0.15, {-0.5, 1})});
       }},
      {"cam", 24,
       [](auto n) {
         const Knots outline =
             "0.5 0 ~, 0.42 0.3 ~, 0.2 0.48 ~, -0.1 0.58 ~, -0.5 0.55 ~, -0.85 0.35 ~, -0.95 0 ~, "
             "-0.85 -0.35 ~, -0.5 -0.55 ~, -0.1 -0.58 ~, 0.2 -0.48 ~, 0.42 -0.3 ~";
         return solid(n, outline, "0 0, 0 0.35", kCadCut, {bore(16, 0.2)});
       }},
      {"hinge", 12, hinge},
      {"cap", 24,
       [](auto n) {
         return lathe(n, "0 0.5, 0.8 0.5, 0.8 0, 0.95 0, 1 0.05, 1 0.5 @90/3, 0.85 0.65, 0 0.65",
                      24, kGameCut);
       }},
      {"drawer handle", 10,
       [](auto n) {
         const PolygonMesh foot = lathe(n, "0 0, 0.2 0, 0.2 0.06, 0.16 0.1, 0 0.1", 10, kLotCut);
         return joined(
             {tube(n, "-0.8 0.05, -0.8 0.3 @-90/4, -0.5 0.6, 0.5 0.6 @-90/4, 0.8 0.3, 0.8 0.05",
                   0.1, 8, kLotCut),
              copied(foot, {{0.8, 0, 0}, {-0.8, 0, 0}})});
       }},
      {"pulley", 24,
       [](auto n) {
         return lathe(n,
                      "0.2 -0.25, 0.4 -0.25, 0.4 -0.15, 0.8 -0.15, 0.8 -0.2, 1 -0.2, 1 -0.15, 0.82 "
                      "0, 1 0.15, 1 0.2, 0.8 0.2, 0.8 0.15, 0.4 0.15, 0.4 0.25, 0.2 0.25",
                      24, kCadCut, true);
       }},
      {"bearing", 20, bearing},
      {"star knob", 20,
       [](auto n) {
         Knots lobes;
         for (int i = 0; i < 5; ++i)
           for (const auto& [part, turn] : {std::pair(0.0, 150.0), {0.6, -78.0}}) {
             const double angle = 2 * std::numbers::pi * (i + part) / 5;
             lobes.push_back({std::cos(angle), std::sin(angle), turn, part == 0 ? 5 : 3});
           }
         return joined({solid(n, lobes, rounded_ends(0.5, 0.1, 2), kCadCut),
                        lathe(n, "0 -0.5, 0.4 -0.5, 0.45 0.2, 0 0.2", 16, kCadCut)});
       }},
      {"piston", 20,
       [](auto n) {
         return lathe(n,
                      "0 0, 0.9 0, 0.9 0.2, 0.84 0.2, 0.84 0.28, 0.9 0.28, 0.9 0.4, 0.84 0.4, 0.84 "
                      "0.48, 0.9 0.48, 0.9 1.3, 0.85 1.35 @13.42/3, 0 1.45",
                      20, kUnevenCut);
       }},
      {"nozzle, uneven", 16,
       [](auto n) {
         return lathe(n,
                      "0.3 0, 0.6 0, 0.6 0.2, 0.45 0.3, 0.35 0.6 ~, 0.45 1 ~, 0.75 1.5, 0.65 1.5 "
                      "~, 0.3 1 ~, 0.2 0.6, 0.3 0.2",
                      16, kUnevenCut, true);
       }},
      {"casting, simplified", 24,
       [](auto n) {
         const PolygonMesh fine =
             solid(8,
                   "-1 -0.5 @90/3, -0.5 -1, 0.5 -1 @90/3, 1 -0.5, 1 0.5 @90/3, 0.5 1, -0.5 1 "
                   "@90/3, -1 0.5",
                   "0.2 0 @-90/2, 0 0.2, 0 0.6, 0.1 0.7", kCadCut, {bore(24, 0.4)});
         return n == 1 ? simplified_within(fine, 3e-3) : fine;
       }},
      {"lever", 16,
       [](auto n) {
         const Knots outline =
             "0.0694 -0.4952, 1.8347 -0.2476 @164.03/6, 1.8347 0.2476, 0.0694 0.4952 @195.97/8";
         return solid(n, outline, "0 0, 0 0.3", kCadCut,
                      {bore(16, 0.28), bore(12, 0.13, {1.8, 0})});
       }},
  };
}

}  // namespace planish::quality
