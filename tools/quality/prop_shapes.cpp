// Of games, houses and roads. Lengths are in what suits the thing; z is up.
#include "quality/prop_shapes.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "quality/irregular_shapes.h"
#include "quality/prop_maker.h"

namespace planish::quality {

namespace {

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

}  // namespace

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

}  // namespace planish::quality
