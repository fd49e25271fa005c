#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "make_scenes/sample_points.h"
#include "planish/features/find_features.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "quality/figures.h"
#include "quality/part_maker.h"
#include "quality/tables.h"
#include "quality/wild_shapes.h"

namespace planish::quality {
namespace {

// A thing as a technical artist has it.
struct Prop {
  std::string name;
  std::int32_t segments;  // around the largest of what is round in it
  // Coarse at 1, which is the prop; its true shape at n has n times as many segments.
  std::function<PolygonMesh(std::int32_t fineness)> make;
};

// Of games, houses and roads. Lengths are in what suits the thing; z is up.

using glm::dvec3;

constexpr dvec3 kOrigin{0, 0, 0};

PolygonMesh box(const dvec3& size, const dvec3& middle, const Cut& cut) {
  return placed(solid(1, rectangle(size.x, size.y), {{0, 0}, {0, size.z}}, cut),
                middle - dvec3(0, 0, size.z / 2));
}

PolygonMesh ball(std::int32_t n, double radius, std::int32_t segments, std::int32_t rings,
                 const Cut& cut) {
  return lathe(n, {{0, -radius, 180, rings}, {0, radius}}, segments, cut);
}

// Both ends flat.
PolygonMesh cylinder(std::int32_t n, double radius, double height, std::int32_t segments,
                     const Cut& cut) {
  return lathe(n, {{radius, 0}, {radius, height}}, segments, cut);
}

// On the x axis, its middle at the origin; rounded shoulders, a hub on both sides.
PolygonMesh car_wheel(std::int32_t n, double radius, double width, std::int32_t segments,
                      const Cut& cut) {
  const double w = width / 2, r = radius, round = 0.4 * w;
  const PolygonMesh wheel = lathe(n,
                                  {{0, -0.8 * w},
                                   {0.3 * r, -0.8 * w},
                                   {0.55 * r, -w},
                                   {r - round, -w, 90, 2},
                                   {r, round - w},
                                   {r, w - round, 90, 2},
                                   {r - round, w},
                                   {0.55 * r, w},
                                   {0.3 * r, 0.8 * w},
                                   {0, 0.8 * w}},
                                  segments, cut);
  return placed(wheel, kOrigin, {0, 90, 0});
}

PolygonMesh four_legs(const PolygonMesh& leg, double x, double y) {
  return copied(leg, {{x, y, 0}, {-x, y, 0}, {-x, -y, 0}, {x, -y, 0}});
}

PolygonMesh rock(std::int32_t n) {
  return hull_of_directions(n == 1 ? 120 : 6000, 31, [](const dvec3& d) {
    const double bumps = std::sin(3 * d.x + 1) + std::sin(4 * d.y + 2 * d.z) + std::cos(3 * d.z);
    return dvec3(1.3, 1, 0.8) * d * (1 + 0.08 * bumps);
  });
}

PolygonMesh crate(std::int32_t) {
  std::vector<PolygonMesh> parts{box({1.8, 1.8, 1.8}, kOrigin, kGameCut)};
  const Knots edge = "0.04 0, 0 0.04, 0 2.06, 0.04 2.1";
  const PolygonMesh beam =
      placed(solid(1, rectangle(0.25, 0.25), edge, kGameCut), {0.9, 0.9, -1.05});
  for (const dvec3& turn : {dvec3(0, 0, 0), dvec3(90, 0, 0), dvec3(0, 90, 0)})
    for (const double quarter : {0.0, 90.0, 180.0, 270.0})
      parts.push_back(placed(placed(beam, kOrigin, {0, 0, quarter}), kOrigin, turn));
  return joined(parts);
}

PolygonMesh wagon(std::int32_t n) {
  const PolygonMesh body =
      solid(n, "-0.5 0, 0.5 0, 0.5 0.8 @180/6, -0.5 0.8", "0 0, 0 2.4", kGameCut);
  return joined(
      {placed(body, {0, 1.2, 0.35}, {90, 0, 0}), box({0.8, 2.7, 0.15}, {0, 0, 0.26}, kGameCut),
       copied(car_wheel(n, 0.25, 0.16, 12, kGameCut),
              {{0.46, 0.8, 0.1}, {-0.46, 0.8, 0.1}, {0.46, -0.8, 0.1}, {-0.46, -0.8, 0.1}}),
       placed(cylinder(n, 0.1, 0.5, 8, kGameCut), {0, 0.7, 1.55})});
}

PolygonMesh car(std::int32_t n) {
  const Knots side =
      "-1.9 0, 1.9 0, 2 0.4 @60/2, 1.75 0.62, 1 0.68, 0.55 1.1 @25/2, -0.7 1.12, -1.25 0.72, -1.9 "
      "0.65 @70/2, -2 0.35";
  const Knots rounding = "0.12 0 @-90/2, 0 0.12, 0 1.48 @-90/2, 0.12 1.6";
  return joined(
      {placed(solid(n, side, rounding, kCadCut), {0, 0.8, 0.3}, {90, 0, 0}),
       copied(placed(car_wheel(n, 0.36, 0.26, 12, kFanCut), kOrigin, {0, 0, 90}),
              {{1.2, 0.78, 0.3}, {1.2, -0.78, 0.3}, {-1.2, 0.78, 0.3}, {-1.2, -0.78, 0.3}})});
}

PolygonMesh lamp_post(std::int32_t n) {
  return joined({lathe(n, "0 0, 0.3 0, 0.3 0.1 ~, 0.16 0.25 ~, 0.1 0.6, 0.06 3, 0 3", 10, kGameCut),
                 lathe(n, "0 2.95, 0.12 2.95, 0.26 3.5, 0.3 3.52, 0 3.75", 6, kGameCut),
                 placed(ball(n, 0.06, 8, 4, kGameCut), {0, 0, 3.8})});
}

PolygonMesh arch(std::int32_t n) {
  const Knots face = "-1.5 0, -1 0, -1 1.2 @-180/8, 1 1.2, 1 0, 1.5 0, 1.5 2.7, -1.5 2.7";
  return placed(solid(n, face, "0 0, 0 0.8", kCadCut), kOrigin, {90, 0, 0});
}

PolygonMesh bridge(std::int32_t n) {
  const Knots face =
      "-3 0, -2 0, -2 0.3 @-120/8, 2 0.3, 2 0, 3 0, 3 1.4, 2.2 1.5 @20/4, -2.2 1.5, -3 1.4";
  const PolygonMesh wall = box({6.2, 0.18, 0.5}, {0, 0, 2.05}, kCadCut);
  return joined({placed(solid(n, face, "0 0, 0 1.6", kCadCut), {0, 0.8, 0}, {90, 0, 0}),
                 copied(wall, {{0, 0.65, -0.2}, {0, -0.65, -0.2}})});
}

PolygonMesh stairs(std::int32_t) {
  Knots face = "0 0, 3.5 0";
  for (int i = 7; i > 0; --i) {
    face.push_back({0.5 * i, 0.3 * (8 - i)});
    face.push_back({0.5 * (i - 1), 0.3 * (8 - i)});
  }
  return placed(solid(1, face, "0 0, 0 1.6", kCadCut), kOrigin, {90, 0, 0});
}

PolygonMesh house(std::int32_t) {
  const Knots gable = "-1 0, 1 0, 1 1, 0 1.5, -1 1";
  const Knots roof = "-1.2 0.9, 0 1.5, 1.2 0.9, 1.2 1.02, 0 1.62, -1.2 1.02";
  return joined({placed(solid(1, gable, "0 0, 0 2.4", kGameCut), {0, 1.2, 0}, {90, 0, 0}),
                 placed(solid(1, roof, "0 0, 0 2.8", kCadCut), {0, 1.4, 0.03}, {90, 0, 0}),
                 box({0.25, 0.3, 0.8}, {0.6, 0.5, 1.5}, kGameCut),
                 box({0.4, 0.1, 0.7}, {0, -1.2, 0.36}, kGameCut)});
}

PolygonMesh boat(std::int32_t n) {
  const Knots section = "-1 1, -0.95 0.5 ~, -0.6 0.1 ~, 0 0 ~, 0.6 0.1 ~, 0.95 0.5 ~, 1 1";
  return placed(loft(n, section,
                     {{0, {0.5, 0.55}, {0, 0.25}},
                      {1, {0.75, 0.7}, {0, 0.05}},
                      {2, {0.85, 0.75}, {0, 0}},
                      {3, {0.75, 0.75}, {0, 0.05}},
                      {4, {0.4, 0.6}, {0, 0.3}},
                      {4.6, {0.05, 0.3}, {0, 0.75}}},
                     true, kQuadCut),
                kOrigin, {90, 0, 0});
}

PolygonMesh rocket(std::int32_t n) {
  const Knots fin = "0.3 0, 0.9 -0.5, 0.95 0.1, 0.3 1";
  const PolygonMesh blade =
      placed(solid(1, fin, "0.02 0, 0 0.03, 0 0.07, 0.02 0.1", kGameCut), {0, 0.05, 0}, {90, 0, 0});
  return joined(
      {lathe(n, "0 0, 0.3 0, 0.42 0.4 ~, 0.48 1.2 ~, 0.42 2 ~, 0.25 2.6 ~, 0.12 2.86 ~, 0 2.94", 12,
             kGameCut),
       lathe(n, "0 -0.02, 0.14 -0.02, 0.24 -0.3, 0.3 -0.3, 0.2 0.1, 0 0.1", 12, kGameCut),
       around_axis(blade, 4)});
}

PolygonMesh sword(std::int32_t n) {
  const Knots diamond = "0.14 0, 0 0.04, -0.14 0, 0 -0.04";
  return joined({loft(1, diamond, {{0.05}, {1.8, {0.8, 0.8}}, {2.2, {0, 0}}}, false, kGameCut),
                 solid(n, "0.27 -0.08 @180/6, 0.27 0.08, -0.27 0.08 @180/6, -0.27 -0.08",
                       "0.02 0, 0 0.02, 0 0.1, 0.02 0.12", kFanCut),
                 lathe(n, "0 -0.5, 0.05 -0.5, 0.065 -0.25 ~, 0.06 0.05, 0 0.05", 8, kGameCut),
                 placed(ball(n, 0.1, 8, 5, kGameCut), {0, 0, -0.56})});
}

PolygonMesh chair(std::int32_t n) {
  const PolygonMesh leg =
      loft(1, rectangle(0.09, 0.09), {{-0.02, {0.7, 0.7}}, {0.9}}, false, kGameCut);
  const Knots back = "-0.45 0 @-60/5, 0.45 0, 0.45 0.1 @60/5, -0.45 0.1";
  return joined(
      {placed(solid(n, rounded_rectangle(1, 1, 0.12, 2), "0 0.88, 0 0.96, 0.04 1", kGameCut),
              kOrigin),
       four_legs(leg, 0.4, 0.4),
       copied(box({0.08, 0.08, 0.9}, {0, 0.4, 1.4}, kGameCut), {{0.4, 0, 0}, {-0.4, 0, 0}}),
       placed(solid(n, back, "0 0, 0 0.35", kCadCut), {0, 0.34, 1.45})});
}

PolygonMesh hourglass(std::int32_t n) {
  const PolygonMesh plate =
      lathe(n, "0 0, 0.6 0, 0.65 0.05, 0.65 0.1, 0.6 0.15, 0 0.15", 12, kGameCut);
  const PolygonMesh glass = lathe(n,
                                  "0 0.1, 0.3 0.1 ~, 0.42 0.4 ~, 0.25 0.75 ~, 0.08 1 ~, 0.25 1.25 "
                                  "~, 0.42 1.6 ~, 0.3 1.9, 0 1.9",
                                  12, kGameCut);
  return joined({plate, placed(plate, {0, 0, 1.85}), glass,
                 around_axis(placed(cylinder(n, 0.05, 1.8, 8, kGameCut), {0.54, 0, 0.1}), 3)});
}

// Props of games, furniture, buildings and vehicles; and parts of machines. What is round in a
// fine one is round, what is sharp there is sharp; polygons of up to six sides stay as they are.
// Where parts of a thing meet, they cross or stand apart: faces that lie on each other would have
// the normals of either.
std::vector<Prop> game_props() {
  return {
      {"mug", 16,
       [](auto n) {
         return joined(
             {lathe(n, "0 0, 0.45 0, 0.5 0.05, 0.5 1, 0.4 1, 0.4 0.1, 0 0.1", 16, kGameCut),
              tube(n, "0.46 0.25 @180/6, 0.46 0.8", 0.06, 8, kGameCut)});
       }},
      {"barrel", 12,
       [](auto n) {
         const PolygonMesh hoop =
             lathe(n, "0.38 0, 0.47 0, 0.48 0.1, 0.38 0.1", 12, kGameCut, true);
         return joined({lathe(n,
                              "0 0.04, 0.34 0.04, 0.34 0, 0.4 0 ~, 0.47 0.35 ~, 0.49 0.6 ~, 0.47 "
                              "0.85 ~, 0.4 1.2, 0.34 1.2, 0.34 1.16, 0 1.16",
                              12, kStripCut),
                        placed(hoop, {0, 0, 0.12}), placed(hoop, {0, 0, 1.08}, {180, 0, 0})});
       }},
      {"bottle", 16,
       [](auto n) {
         return lathe(n,
                      "0 0.06, 0.24 0, 0.3 0 @90/2, 0.36 0.06, 0.36 0.9 @60/3, 0.18 1.2118 @-60/2, "
                      "0.13 1.2984, 0.13 1.7, 0.17 1.7, 0.17 1.8, 0 1.8",
                      16, kGameCut);
       }},
      {"goblet", 12,
       [](auto n) {
         return lathe(n,
                      "0 0, 0.42 0, 0.42 0.05 ~, 0.15 0.12 ~, 0.08 0.4 ~, 0.13 0.6 ~, 0.4 0.8 ~, "
                      "0.46 1.3, 0.38 1.3 ~, 0.3 0.9 ~, 0 0.72",
                      12, kGameCut);
       }},
      {"plate", 20,
       [](auto n) {
         return lathe(n, "0 0, 0.55 0, 0.95 0.14, 1 0.2, 0.92 0.22, 0.55 0.08, 0 0.08", 20,
                      kFanCut);
       }},
      {"bowl", 12,
       [](auto n) {
         return lathe(n, "0 0, 0.4 0, 0.4 0.08 @50/3, 1 0.7, 0.85 0.72 @-64.86/4, 0 0.18", 12,
                      kQuadCut);
       }},
      {"sword", 8, sword},
      {"round shield", 16,
       [](auto n) {
         return joined(
             {lathe(n, "0 0 @-35.05/3, 0.95 -0.3, 0.95 -0.2 @37.24/3, 0 0.12", 16, kGameCut),
              lathe(n, "0.88 -0.32, 1.02 -0.32, 1.02 -0.14, 0.88 -0.14", 16, kGameCut, true),
              lathe(n, "0 0.02, 0.25 0.02, 0.25 0.1 @90/3, 0 0.35", 16, kGameCut)});
       }},
      {"hammer", 10,
       [](auto n) {
         return joined(
             {placed(lathe(n,
                           "0 -0.5, 0.22 -0.5, 0.25 -0.47, 0.25 -0.3, 0.18 -0.2, 0.18 0.2, 0.25 "
                           "0.3, 0.25 0.47, 0.22 0.5, 0 0.5",
                           10, kGameCut),
                     {0, 0, 1.6}, {0, 90, 0}),
              lathe(n, "0 0, 0.09 0, 0.1 0.3 ~, 0.07 0.9 ~, 0.07 1.9, 0 1.9", 8, kGameCut)});
       }},
      {"crate with frame", 4, crate},
      {"chest", 12,
       [](auto n) {
         const Knots lid = "-0.5 0, 0.5 0, 0.5 0.05 @180/6, -0.5 0.05";
         const Knots band = "-0.55 0.02, 0.55 0.02, 0.55 0.05 @180/6, -0.55 0.05";
         return joined(
             {box({1.6, 1, 0.7}, {0, 0, 0.35}, kGameCut),
              placed(solid(n, lid, "0 0, 0 1.6", kGameCut), {-0.8, 0, 0.72}, {90, 0, 90}),
              copied(placed(solid(n, band, "0 0, 0 0.15", kGameCut), {-0.5, 0, 0.72}, {90, 0, 90}),
                     {kOrigin, {0.85, 0, 0}}),
              box({0.2, 0.12, 0.25}, {0, -0.51, 0.7}, kGameCut)});
       }},
      {"table", 8,
       [](auto n) {
         const PolygonMesh leg = lathe(
             n, "0 0, 0.05 0, 0.09 0.2 ~, 0.05 0.5 ~, 0.08 0.85, 0.08 1.05, 0 1.05", 8, kGameCut);
         return joined({solid(n, rounded_rectangle(2.4, 1.4, 0.2, 3),
                              "0.05 1, 0 1.05, 0 1.13 @-90/2, 0.05 1.18", kFanCut),
                        four_legs(leg, 1, 0.5)});
       }},
      {"chair", 8, chair},
      {"stool", 12,
       [](auto n) {
         const PolygonMesh leg =
             placed(cylinder(n, 0.05, 1, 8, kLotCut), {0.42, 0, 0}, {0, -15, 0});
         return joined(
             {lathe(n, "0 0.93, 0.45 0.93, 0.5 0.97 @90/2, 0.44 1.05, 0 1.02", 12, kLotCut),
              around_axis(leg, 3)});
       }},
      {"lamp post", 10, lamp_post},
      {"fountain", 16,
       [](auto n) {
         return joined(
             {solid(n, rectangle(3, 3), "0 0, 0 0.15, 0.1 0.2", kGameCut),
              lathe(n, "0 0.1, 1.1 0.1, 1.3 0.7, 1.1 0.7, 1 0.4, 0 0.4", 16, kGameCut),
              lathe(n, "0 0.35, 0.25 0.35, 0.12 0.8 ~, 0.15 1.2 ~, 0.6 1.5, 0.45 1.5, 0 1.35", 16,
                    kGameCut)});
       }},
      {"round platform", 20,
       [](auto n) {
         return joined({lathe(n, "0 0, 0.9 0, 1 0.1, 1 0.5, 0 0.5", 20, kGameCut),
                        lathe(n, "0 0.45, 1.06 0.45, 1.1 0.5, 1.1 0.62 @90/2, 1.02 0.7, 0 0.7", 20,
                              kGameCut)});
       }},
      {"square platform", 12,
       [](auto n) {
         return joined({solid(n, rounded_rectangle(2, 2, 0.3, 3), "0.1 0, 0 0.1, 0 0.5", kGameCut),
                        solid(n, rounded_rectangle(2.2, 2.2, 0.4, 3),
                              "0 0.45, 0 0.62 @-90/2, 0.08 0.7", kGameCut)});
       }},
      {"coin", 24,
       [](auto n) {
         return lathe(n,
                      "0 0, 0.8 0, 0.84 -0.04, 0.98 -0.04, 1 -0.02, 1 0.14, 0.98 0.16, 0.84 0.16, "
                      "0.8 0.12, 0 0.12",
                      24, kGameCut);
       }},
      {"gem", 6,
       [](auto n) { return lathe(n, "0 -1, 0.8 0, 0.8 0.1, 0.5 0.4, 0 0.4", 6, kGameCut); }},
      {"tree of cones", 8,
       [](auto n) {
         const auto cone = [&](double z, double r) {
           return lathe(n, {{0, z}, {r, z - 0.1}, {0, z + 1.1 * r}}, 8, kGameCut);
         };
         return joined({cylinder(n, 0.15, 0.7, 6, kGameCut), cone(0.6, 0.8), cone(1.1, 0.65),
                        cone(1.6, 0.45)});
       }},
      {"rock", 16, rock},
      {"mushroom", 12,
       [](auto n) {
         return joined({lathe(n, "0 0, 0.25 0 ~, 0.17 0.3 ~, 0.15 0.85, 0 0.85", 12, kGameCut),
                        lathe(n, "0 0.8, 0.6 0.6, 0.68 0.66 ~, 0.6 0.95 ~, 0.35 1.2 ~, 0 1.3", 12,
                              kGameCut)});
       }},
      {"candle in a holder", 12,
       [](auto n) {
         return joined(
             {lathe(n, "0 0, 0.5 0, 0.6 0.15, 0.5 0.15, 0.45 0.08, 0.2 0.08, 0.2 0.3, 0 0.3", 12,
                    kFanCut),
              cylinder(n, 0.13, 1, 10, kFanCut), placed(ball(n, 0.06, 6, 4, kFanCut), {0, 0, 1.05}),
              placed(tube(n, "0.5 0.1 @180/5, 0.5 0.4", 0.05, 6, kFanCut), {0, 0, -0.02})});
       }},
      {"car", 12, car},
      {"boat hull", 12, boat},
      {"train wagon", 12, wagon},
      {"house with gable roof", 4, house},
      {"tower with cone roof", 12,
       [](auto n) {
         return joined(
             {lathe(n, "0 0, 0.6 0, 0.5 0.4, 0.5 2, 0.62 2.2, 0.62 2.5, 0 2.5", 12, kGameCut),
              lathe(n, "0 2.55, 0.75 2.45, 0 3.6", 12, kGameCut),
              box({0.3, 0.2, 0.6}, {0, -0.52, 0.3}, kGameCut)});
       }},
      {"arch", 16, arch},
      {"stairs", 4, stairs},
      {"well", 12,
       [](auto n) {
         const Knots roof = "-0.9 0, 0 0.5, 0.9 0, 0.9 0.12, 0 0.62, -0.9 0.12";
         return joined(
             {lathe(n, "0 0, 0.8 0, 0.8 0.7, 0.6 0.7, 0.6 0.1, 0 0.1", 12, kGameCut),
              copied(box({0.12, 0.12, 1.6}, {0, 0, 0.9}, kGameCut), {{0.7, 0, 0}, {-0.7, 0, 0}}),
              placed(cylinder(n, 0.08, 1.6, 8, kGameCut), {-0.8, 0, 1.2}, {0, 90, 0}),
              placed(solid(1, roof, "0 0, 0 2", kCadCut), {-1, 0, 1.55}, {90, 0, 90})});
       }},
      {"bridge", 24, bridge},
      {"column", 16,
       [](auto n) {
         return joined({solid(n, rectangle(1, 1), "0 0, 0 0.15", kGameCut),
                        lathe(n,
                              "0 0.1, 0.45 0.1, 0.45 0.2 @180/4, 0.45 0.32, 0.36 0.36, 0.34 1.5 ~, "
                              "0.32 2.2 ~, 0.28 2.9, 0.34 2.95, 0.45 3.1, 0 3.1",
                              16, kGameCut),
                        solid(n, rectangle(1, 1), "0 3.05, 0 3.2", kGameCut)});
       }},
      {"rocket", 12, rocket},
      {"bullet", 16,
       [](auto n) {
         return lathe(n,
                      "0 0, 0.5 0, 0.5 0.1, 0.42 0.15, 0.42 0.2, 0.5 0.3, 0.47 1.7, 0.4 1.8, 0.4 "
                      "2.1 ~, 0.32 2.6 ~, 0.18 2.86 ~, 0 2.95",
                      16, kStripCut);
       }},
      {"hourglass", 12, hourglass},
      {"vase, simplified", 16,
       [](auto n) {
         const PolygonMesh fine = lathe(8,
                                        "0 0, 0.4 0 ~, 0.6 0.4 ~, 0.5 0.9 ~, 0.22 1.2 ~, 0.4 1.5, "
                                        "0.3 1.5 ~, 0.12 1.2 ~, 0.2 0.6, 0 0.5",
                                        16, kGameCut);
         return n == 1 ? simplified_within(fine, 4e-3) : fine;
       }},
  };
}

// Parts of machines and tools. Lengths are in what suits the thing; z is up.

using glm::dvec2;

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

// Segments of the true shape, and how many times those of the prop they are at least.
constexpr std::int32_t kTrueSegments = 256, kLeastFineness = 8;

// A figure against another body would say nothing: the prop's vertices lie on the true shape, but
// for what its facets cut off beside a vertex between two of its meridians.
void check_truth(const Case& made) {
  constexpr double kOff = 1e-3;  // of the diagonal
  const Truth truth = true_mesh(made.source);
  const double most = kOff * placement_of(made.mesh).diagonal;
  for (const glm::dvec3& p : made.mesh.positions)
    if (glm::distance(truth(p).point, p) > most)
      throw std::logic_error(made.name + " is not coarsely what it is finely");
}

Case case_of(const Prop& prop, bool is_held_out) {
  Case made{prop.name, prop.make(1), {}};
  // One number for all of a thing's parts: what is smaller has fewer segments, coarse and fine.
  made.source = prop.make(std::max(kLeastFineness, kTrueSegments / prop.segments));
  made.has_smooth_source = true;
  made.is_held_out = is_held_out;
  check_truth(made);
  return made;
}

std::vector<std::pair<std::string, MeshFitOptions>> all_flags() {
  auto all = mesh_flags();
  for (const double degrees : {20.0, 35.0}) {
    for (const QuadChoice quads : {QuadChoice::Off, QuadChoice::On}) {
      MeshFitOptions options;
      options.method = InterpolationMethod::Fair;
      options.chooses_creases = false;
      options.crease_degrees = degrees;
      options.quads = quads;
      all.emplace_back("fair, creases from " + std::to_string(static_cast<int>(degrees)) +
                           (quads == QuadChoice::On ? ", quads" : ""),
                       options);
    }
  }
  return all;
}

// Edges that are sharp in the shapes, and others, by what is found in the props.
struct EdgeTally {
  std::int64_t found = 0, missed = 0, more = 0;

  void add(const Case& made) {
    const TruePieces pieces(made.source, made.mesh);
    const MeshTopology topology(made.mesh);
    std::set<std::pair<std::int32_t, std::int32_t>> sharp;
    for (const CreaseEdge& edge : find_features(made.mesh, topology).sharp_edges())
      sharp.insert(std::minmax(edge.v0, edge.v1));
    for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
      const std::int32_t corner = topology.corner_of(e), twin = topology.twin(corner);
      if (twin < 0) continue;
      const auto [v, w] = topology.edge_vertices(e);
      const bool is_found = sharp.contains(std::minmax(v, w));
      const bool is_sharp = pieces.are_apart(topology.face_of(corner), topology.face_of(twin));
      found += is_sharp && is_found ? 1 : 0;
      missed += is_sharp && !is_found ? 1 : 0;
      more += !is_sharp && is_found ? 1 : 0;
    }
  }
};

}  // namespace

std::vector<NamedCase> prop_cases() {
  // Of each two in a row one: those that are added at the end leave the others where they are.
  shapes::RandomNumbers lot(1941);
  std::vector<NamedCase> cases;
  std::int32_t held_out = 0;
  for (auto* list : {&game_props, &machine_props}) {
    std::int32_t place = 0;
    for (const Prop& prop : list()) {
      if (place % 2 == 0) held_out = lot.below(2);
      const bool is_held_out = place++ % 2 == held_out;
      cases.push_back({prop.name, [prop, is_held_out] { return case_of(prop, is_held_out); }});
    }
  }
  return cases;
}

std::vector<std::string> print_prop_table(const std::vector<NamedCase>& cases) {
  const auto backend = make_cpu_backend();
  OutcomeTable table(false);
  std::array<EdgeTally, 2> edges;
  for (const NamedCase& named : cases) {
    const Case made = named.make();
    std::vector<Outcome> others;
    for (const auto& [flags, options] : all_flags())
      others.push_back(fitted(made, flags, options, *backend));
    table.add(made, nullptr, fitted(made, "", {}, *backend), others);
    edges[made.is_held_out ? 1 : 0].add(made);
  }
  std::vector<std::string> wrong = table.finish();
  for (const bool is_held_out : {false, true}) {
    const EdgeTally& tally = edges[is_held_out ? 1 : 0];
    std::printf("%s: %lld sharp edges found, %lld missed, %lld more\n",
                is_held_out ? "held out (*)" : "others", static_cast<long long>(tally.found),
                static_cast<long long>(tally.missed), static_cast<long long>(tally.more));
  }
  return wrong;
}

}  // namespace planish::quality
