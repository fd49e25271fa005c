// Surfaces that CAD programs know by name: their distances, fits and guesses.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "planish/analytic/analytic_surface.h"
#include "planish/analytic/border_curves.h"

namespace planish::test {
namespace {

const glm::dvec3 kAxis = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));

std::vector<AnalyticSurface> some_surfaces() {
  const glm::dvec3 origin(0.1, 0.2, -0.3);
  return {
      {.kind = AnalyticKind::Plane, .origin = origin, .axis = kAxis},
      {.kind = AnalyticKind::Cylinder, .origin = origin, .axis = kAxis, .radius = 0.4},
      {.kind = AnalyticKind::Cone, .origin = origin, .axis = kAxis, .slope = 0.365},
      {.kind = AnalyticKind::Sphere, .origin = origin, .radius = 0.6},
      {.kind = AnalyticKind::Torus, .origin = origin, .axis = kAxis, .radius = 0.5, .minor = 0.2}};
}

// A patch of the surface, m x m points.
std::vector<glm::dvec3> patch_of(const AnalyticSurface& s, int m) {
  const AxisFrame frame(s.axis);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j < m; ++j) {
      const double u = 0.2 + 1.1 * i / m, v = 0.3 + 0.9 * j / m;
      const glm::dvec3 away = std::cos(u) * frame.x + std::sin(u) * frame.y;
      switch (s.kind) {
        case AnalyticKind::Plane:
          points.push_back(s.origin + u * frame.x + v * frame.y);
          break;
        case AnalyticKind::Cylinder:
          points.push_back(s.origin + s.radius * away + v * s.axis);
          break;
        case AnalyticKind::Cone:
          points.push_back(s.origin + v * (s.slope * away + s.axis));
          break;
        case AnalyticKind::Sphere:
          points.push_back(s.origin + s.radius * (std::cos(v) * away + std::sin(v) * s.axis));
          break;
        case AnalyticKind::Torus:
          points.push_back(s.origin + (s.radius + s.minor * std::cos(v)) * away +
                           s.minor * std::sin(v) * s.axis);
      }
    }
  }
  return points;
}

TEST(AnalyticSurfaces, PointsHaveTheirDistance) {
  for (const AnalyticSurface& s : some_surfaces()) {
    SCOPED_TRACE(std::string(name_of(s.kind)));
    for (const glm::dvec3& p : patch_of(s, 5)) {
      EXPECT_NEAR(signed_distance(s, p), 0, 1e-15);
      const glm::dvec3 normal = normal_at(s, p);
      EXPECT_NEAR(glm::length(normal), 1, 1e-14);
      for (const double off : {-0.05, 0.07})
        EXPECT_NEAR(signed_distance(s, p + off * normal), off, 1e-14);
    }
  }
}

TEST(AnalyticSurfaces, GradientsAreThoseOfDifferences) {
  constexpr double kStep = 1e-6;
  for (const AnalyticSurface& s : some_surfaces()) {
    SCOPED_TRACE(std::string(name_of(s.kind)));
    for (const glm::dvec3& on : patch_of(s, 3)) {
      const glm::dvec3 p = on + glm::dvec3(0.02, -0.03, 0.01);
      const SurfaceChange gradient = distance_gradient(s, p);
      for (const std::uint8_t change : changes_of(s.kind)) {
        SurfaceChange forward{}, back{};
        forward[change] = kStep;
        back[change] = -kStep;
        const double slope =
            (signed_distance(changed(s, forward), p) - signed_distance(changed(s, back), p)) /
            (2 * kStep);
        EXPECT_NEAR(gradient[change], slope, 1e-8) << int(change);
      }
    }
  }
}

TEST(AnalyticSurfaces, AreFoundFromNearby) {
  for (const AnalyticSurface& s : some_surfaces()) {
    SCOPED_TRACE(std::string(name_of(s.kind)));
    const std::vector<glm::dvec3> points = patch_of(s, 8);
    const SurfaceChange off{0.02, -0.03, 0.01, 0.02, -0.01, 0.02, -0.01};
    SurfaceChange by{};
    for (const std::uint8_t change : changes_of(s.kind)) by[change] = off[change];
    AnalyticSurface fitted = changed(s, by);
    EXPECT_LT(fit_surface(fitted, points), 1e-12);
    EXPECT_NEAR(fitted.radius, s.radius, 1e-10);
    EXPECT_NEAR(fitted.minor, s.minor, 1e-10);
    EXPECT_NEAR(fitted.slope, s.slope, 1e-10);
    if (s.kind != AnalyticKind::Sphere) {
      EXPECT_NEAR(std::abs(glm::dot(fitted.axis, s.axis)), 1, 1e-13);
    }
  }
}

TEST(AnalyticSurfaces, TooFewPointsTellNone) {
  AnalyticSurface torus = some_surfaces()[4];
  const std::vector<glm::dvec3> points = patch_of(torus, 2);
  EXPECT_EQ(fit_surface(torus, points), std::numeric_limits<double>::infinity());
}

// What two surfaces share is told as what it is, and lies on both.
TEST(BorderCurves, AreLinesCirclesAndEllipsesWhereTheyCanBe) {
  const AnalyticSurface cylinder{.kind = AnalyticKind::Cylinder, .radius = 0.3};
  const AnalyticSurface ball{.kind = AnalyticKind::Sphere, .radius = 0.5};
  const auto plane = [](const glm::dvec3& origin, const glm::dvec3& axis) {
    return AnalyticSurface{
        .kind = AnalyticKind::Plane, .origin = origin, .axis = glm::normalize(axis)};
  };
  const AnalyticSurface flat = plane({0, 0, 0.2}, {0, 0, 1}), slanted = plane({0, 0, 0}, {0, 1, 2}),
                        upright = plane({0.1, 0, 0}, {1, 0, 0});
  const AnalyticSurface other{.kind = AnalyticKind::Cylinder, .axis = {1, 0, 0}, .radius = 0.2};
  struct Case {
    const AnalyticSurface &a, &b;
    glm::dvec3 from, to;  // near
    CurveKind kind;
  };
  const double y = std::sqrt(0.08);
  for (const Case& c :
       {Case{flat, cylinder, {0.3, 0, 0.2}, {0, 0.3, 0.2}, CurveKind::Circle},
        Case{slanted, cylinder, {0.3, 0, 0}, {0, 0.3, -0.15}, CurveKind::Ellipse},
        Case{upright, cylinder, {0.1, y, 0}, {0.1, y, 0.4}, CurveKind::Line},
        Case{ball, cylinder, {0.3, 0, 0.4}, {0, 0.3, 0.4}, CurveKind::Circle},
        Case{flat, ball, {std::sqrt(0.21), 0, 0.2}, {0, std::sqrt(0.21), 0.2}, CurveKind::Circle},
        Case{other, cylinder, {0.3, 0, 0.2}, {std::sqrt(0.05), 0.2, 0}, CurveKind::Spline}}) {
    const BorderSides sides{{&c.a, 1}, {&c.b, 1}, false};
    double reach = 0;
    const glm::dvec3 from = sides.point(c.from, reach), to = sides.point(c.to, reach);
    const glm::dvec3 middle = sides.point(0.5 * (c.from + c.to), reach);
    ASSERT_LT(reach, 1e-15);
    const auto curve = curve_along(sides, {{from, middle, to}});
    ASSERT_TRUE(curve);
    EXPECT_EQ(curve->kind, c.kind);
    for (const glm::dvec3& p : places_along(*curve, from, to)) {
      EXPECT_LE(std::abs(signed_distance(c.a, p)), kOnSurface);
      EXPECT_LE(std::abs(signed_distance(c.b, p)), kOnSurface);
    }
  }
}

TEST(BorderCurves, AreNoneWhereSurfacesDoNotMeet) {
  const AnalyticSurface plane{.origin = {0, 0, 0.6}},
      ball{.kind = AnalyticKind::Sphere, .radius = 0.5};
  const BorderSides sides{{&plane, 1}, {&ball, 1}, false};
  EXPECT_FALSE(curve_along(sides, {{{0.1, 0, 0.55}, {0.1, 0.1, 0.55}, {0, 0.1, 0.55}}}));
}

TEST(BorderCurves, ParametersAreThoseOfThePoints) {
  const AnalyticSurface a{.kind = AnalyticKind::Cylinder, .axis = {1, 0, 0}, .radius = 0.2},
      cone{.kind = AnalyticKind::Cone, .origin = {0, 0, -1}, .slope = 0.3};
  const BorderSides sides{{&a, 1}, {&cone, 1}, false};
  double reach = 0;
  std::vector<glm::dvec3> chain;
  for (int i = 0; i <= 12; ++i) {
    const double angle = 2 * std::numbers::pi * i / 12;
    chain.push_back(sides.point({0.3, 0.2 * std::cos(angle), 0.2 * std::sin(angle)}, reach));
    ASSERT_LT(reach, 1e-14);
  }
  chain.back() = chain.front();
  const auto curve = curve_along(sides, chain);
  ASSERT_TRUE(curve);
  ASSERT_EQ(curve->kind, CurveKind::Spline);
  const glm::dvec3 along = AxisFrame(cone.axis).x;
  const ParameterCurve flat = parameter_curve(cone, along, 0.5, *curve);
  ASSERT_EQ(flat.points.size(), curve->points.size());
  EXPECT_NEAR(glm::length(flat.points.front() - parameters_of(cone, along, 0.5, chain.front())), 0,
              1e-12);
  EXPECT_NEAR(glm::length(flat.points.front() - flat.points.back()), 0, 1e-9);
}

}  // namespace
}  // namespace planish::test
