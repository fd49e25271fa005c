#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <string>

#include "limit/limit_case.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/queries/closest_point.h"
#include "planish/queries/surface_queries.h"
#include "support/calls.h"

namespace planish::test {
namespace {

using ::testing::HasSubstr;

// The nearest of a dense grid of samples, each improved until nothing nearby is nearer: by halving
// a pattern of steps, which knows nothing of derivatives, boxes or trees.
double brute_force(const LimitCase& c, const std::vector<std::vector<SurfaceParameter>>& places,
                   const std::vector<std::vector<glm::dvec3>>& samples, const glm::dvec3& point) {
  struct Start {
    double square;
    std::size_t corner, sample;
  };
  std::vector<Start> starts;
  for (std::size_t corner = 0; corner < samples.size(); ++corner) {
    Start best{1e300, corner, 0};
    for (std::size_t i = 0; i < samples[corner].size(); ++i) {
      const glm::dvec3 off = samples[corner][i] - point;
      if (glm::dot(off, off) < best.square) best = {glm::dot(off, off), corner, i};
    }
    starts.push_back(best);
  }
  std::ranges::sort(starts, {}, &Start::square);
  double nearest = 1e300;
  LimitSurface::Corner corner(c.limit);
  const Placement& placement = c.surface->placement();
  for (std::size_t k = 0; k < std::min<std::size_t>(starts.size(), 12); ++k) {
    const CornerParameter in =
        corner_parameter(c.limit.topology(), places[starts[k].corner][starts[k].sample]);
    corner.move_to(in.corner);
    const auto distance = [&](double u, double v) {
      return glm::length(placement.to_model(corner.at({u, v}).position) - point);
    };
    double u = in.u, v = in.v, step = 1.0 / 16, here = distance(u, v);
    while (step > 1e-9) {
      bool better = false;
      for (const auto& [du, dv] :
           {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}) {
        const double nu = std::clamp(u + step * du, 0.0, 1.0);
        const double nv = std::clamp(v + step * dv, 0.0, 1.0);
        const double there = distance(nu, nv);
        if (there < here) {
          here = there;
          u = nu;
          v = nv;
          better = true;
          break;
        }
      }
      if (!better) step *= 0.5;
    }
    nearest = std::min(nearest, here);
  }
  return nearest;
}

// Of `each` points so far off the surface by a normal distribution, for each distance.
void expect_nearest(const PolygonMesh& mesh, int each, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const LimitCase c(mesh);
  const SurfaceQueries queries_of(c.limit);
  const MeshTopology& topology = c.limit.topology();
  std::vector<std::vector<SurfaceParameter>> places;
  std::vector<std::vector<glm::dvec3>> samples;
  for (std::int32_t corner = 0; corner < topology.corner_count(); ++corner) {
    if (!c.surface->hidden().empty() && c.surface->hidden()[topology.face_of(corner)] != 0)
      continue;
    places.emplace_back();
    samples.emplace_back();
    for (int i = 0; i < 81; ++i) {
      const int row = i / 9, column = i % 9;
      places.back().push_back(surface_parameter(topology, corner, column / 8.0, row / 8.0));
      samples.back().push_back(c.limit.evaluate(places.back().back()).position);
    }
  }
  const double size = c.surface->placement().diagonal;
  for (const double off : {1e-4, 1e-2, 0.1, 0.5}) {
    for (int i = 0; i < each; ++i) {
      const glm::dvec3 on = c.limit.evaluate(c.any_place(random)).position;
      const double x = normal(random), y = normal(random);
      const glm::dvec3 point = on + off * size * glm::dvec3(x, y, normal(random));
      const ClosestPoint found = queries_of.closest(point);
      const double wanted = brute_force(c, places, samples, point);
      ASSERT_LT(found.distance, wanted + 1e-12 * size) << off << " " << i;
      ASSERT_NEAR(glm::length(found.position - point), found.distance, 1e-15 * size);
      ASSERT_LT(glm::length(c.limit.evaluate(found.at).position - found.position), 1e-15 * size);
    }
  }
}

// As a damaged file has it: one vertex is so far off that all others are one place beside it, and
// the faces at it lines.
TEST(Nearest, SurfacesWithoutWidthAreSearchedToTheirEnd) {
  for (const double far : {1e12, 1e16, 1e34}) {
    PolygonMesh mesh = test::icosphere(2);
    mesh.positions[40] *= far;
    mesh.positions[90] *= 1e-4 * far;
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const SurfaceMesh places = c.tessellated(2);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 20; ++i) {
      // Near the crowd, and along the needles.
      const glm::dvec3 point = glm::dvec3(unit(random), unit(random), unit(random)) +
                               (i % 2) * std::abs(unit(random)) * mesh.positions[40];
      const ClosestPoint closest = queries.closest(point);
      EXPECT_NEAR(glm::length(closest.position - point), closest.distance, 1e-12 * far);
      double least = 1e300;
      for (const glm::dvec3& p : places.positions) least = std::min(least, glm::distance(p, point));
      EXPECT_LE(closest.distance, least + 1e-11 * far);
    }
  }
}

TEST(ClosestPoint, IsTheNearestOfAll) {
  std::mt19937 random(11);
  const std::vector<NamedMesh> meshes = limit_meshes();
  // PLANISH_LONG_RUN=20000 asks as often.
  const int each = std::max(6, run_length(0) / (4 * static_cast<int>(meshes.size())));
  for (const auto& [name, mesh] : meshes) {
    SCOPED_TRACE(name);
    expect_nearest(mesh, each, random);
  }
  EXPECT_GT(meshes.size(), 20u);
}

// Around a vertex of valence 2 the surface comes to a tip that is no polynomial however near.
TEST(ClosestPoint, IsFoundBesideVerticesOfValenceTwo) {
  std::mt19937 random(77);
  expect_nearest(cube_with_split_edges(), 100, random);
}

// The nearest place by nothing but positions: from samples of corners whose balls come near enough,
// downhill from all that are nearer than those around them.
class PlaceOracle {
 public:
  PlaceOracle(const LimitCase& c, int side) : corner_(c.limit), side_(side) {
    for (std::int32_t n = 0; n < c.limit.topology().corner_count(); ++n) {
      corner_.move_to(n);
      Ball ball{n, glm::dvec3(0.0), 0, {}};
      for (int j = 0; j <= side; ++j)
        for (int i = 0; i <= side; ++i)
          ball.samples.push_back(at(double(i) / side, double(j) / side));
      for (const glm::dvec3& p : ball.samples)
        ball.middle += p / static_cast<double>(ball.samples.size());
      for (const glm::dvec3& p : ball.samples)
        ball.radius = std::max(ball.radius, 1.2 * glm::length(p - ball.middle));
      balls_.push_back(std::move(ball));
    }
  }

  /// In unit coordinates, and from there.
  double distance(const glm::dvec3& point, double enough) {
    std::vector<std::pair<double, const Ball*>> near;
    for (const Ball& ball : balls_)
      near.emplace_back(glm::length(ball.middle - point) - ball.radius, &ball);
    std::ranges::sort(near);
    double best = 1e300;
    for (const auto& [least, ball] : near) {
      if (least > best) break;
      corner_.move_to(ball->corner);
      best = std::min(best, in_corner(ball->samples, point, std::min(best, enough)));
    }
    return best;
  }

 private:
  struct Ball {
    std::int32_t corner;
    glm::dvec3 middle;
    double radius;
    std::vector<glm::dvec3> samples;
  };
  glm::dvec3 at(double u, double v) { return corner_.at({u, v}).position; }

  double in_corner(const std::vector<glm::dvec3>& samples, const glm::dvec3& point, double enough) {
    const int row = side_ + 1;
    const auto length = [&](int i, int j) { return glm::length(samples[i + row * j] - point); };
    double best = 1e300;
    for (int j = 0; j <= side_; ++j) {
      for (int i = 0; i <= side_; ++i) {
        const double here = length(i, j);
        bool is_lowest = true;
        double step = 0;
        for (int b = std::max(0, j - 1); b <= std::min(side_, j + 1); ++b) {
          for (int a = std::max(0, i - 1); a <= std::min(side_, i + 1); ++a) {
            is_lowest &= length(a, b) >= here;
            step = std::max(step, glm::length(samples[a + row * b] - samples[i + row * j]));
          }
        }
        if (is_lowest && here - 2 * step <= enough)
          best = std::min(best, downhill(double(i) / side_, double(j) / side_, point));
      }
    }
    return best;
  }

  // By a pattern of steps, which turns and shrinks.
  double downhill(double u, double v, const glm::dvec3& point) {
    double step = 0.7 / side_, here = glm::length(at(u, v) - point);
    for (int turn = 0; step > 1e-10; ++turn) {
      bool better = false;
      for (int k = 0; k < 8 && !better; ++k) {
        const double angle = 0.785398163397448 * k + 0.1 * turn;
        const double nu = std::clamp(u + step * std::cos(angle), 0.0, 1.0);
        const double nv = std::clamp(v + step * std::sin(angle), 0.0, 1.0);
        const double there = glm::length(at(nu, nv) - point);
        if (there >= here) continue;
        here = there;
        u = nu;
        v = nv;
        better = true;
      }
      step *= better ? 1.3 : 0.6;
    }
    return here;
  }

  LimitSurface::Corner corner_;
  int side_;
  std::vector<Ball> balls_;
};

// Places of the surface, more of them where it bends tightly.
template <class Random>
SurfaceParameter bent_place(const LimitCase& c, Random& random) {
  const double size = c.surface->placement().diagonal;
  SurfaceParameter best = c.any_place(random);
  double most = 0;
  for (int i = 0; i < 12; ++i) {
    const SurfaceParameter place = c.any_place(random);
    const PointCurvature curvature = c.limit.evaluate(place).curvature();
    const double bend = size * std::max(std::abs(curvature.largest), std::abs(curvature.smallest));
    if (!curvature.is_known || bend < most || bend > 1e4) continue;
    best = place;
    most = bend;
  }
  return best;
}

TEST(ClosestPoint, OfAPlaceIsThePlaceWhereTheSurfaceBendsTightly) {
  std::mt19937 random(31);
  for (const std::uint32_t seed : {5u, 22u}) {
    const LimitCase c(interpolating_cage(random_dual(120, seed)));
    const SurfaceQueries queries(c.limit);
    std::vector<glm::dvec3> points;
    for (int i = 0; i < run_length(12'000) / 2; ++i)
      points.push_back(c.limit.evaluate(bent_place(c, random)).position);
    std::vector<ClosestPoint> found(points.size());
    queries.closest(points, found);
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_LT(found[i].distance, 1e-12 * c.surface->placement().diagonal) << seed << " " << i;
  }
}

// Where two places of a piece, and of its neighbours, are nearly as near as each other.
TEST(ClosestPoint, IsTheNearestBesideCentresOfCurvature) {
  std::mt19937 random(32);
  std::normal_distribution<double> normal;
  for (const PolygonMesh& mesh : {interpolating_cage(random_dual(120, 5)), random_closed_mesh(2)}) {
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    PlaceOracle oracle(c, 16);
    const double size = c.surface->placement().diagonal;
    for (int i = 0; i < run_length(300) / 2; ++i) {
      const SurfacePoint on = c.limit.evaluate(bent_place(c, random));
      const PointCurvature curvature = on.curvature();
      if (!curvature.is_known) continue;
      const double bend = i % 2 == 0 ? curvature.largest : curvature.smallest;
      if (std::abs(bend) * size < 1) continue;
      const double aside = std::pow(10.0, -1 - i % 6) * normal(random);
      const double x = normal(random), y = normal(random);
      const glm::dvec3 point = on.position - (1 + aside) / bend * on.normal +
                               1e-3 * aside * size * glm::dvec3(x, y, normal(random));
      const ClosestPoint found = queries.closest(point);
      ASSERT_LE(found.distance, glm::length(point - on.position) + 1e-12 * size) << i;
      const double wanted = size * oracle.distance(c.surface->placement().to_unit(point),
                                                   found.distance / size + 1e-9);
      ASSERT_LT(found.distance, wanted + 1e-12 * size) << i;
    }
  }
}

TEST(ClosestPoint, LiesAlongTheNormalInside) {
  const LimitCase c(torus(12, 8, 2, 1));
  const SurfaceQueries queries(c.limit);
  std::mt19937 random(12);
  for (int i = 0; i < 200; ++i) {
    const SurfacePoint on = c.limit.evaluate(c.any_place(random));
    const ClosestPoint found = queries.closest(on.position + 0.05 * on.normal);
    EXPECT_NEAR(found.distance, 0.05, 1e-12);
    EXPECT_LT(glm::length(found.position - on.position), 1e-7);
  }
}

TEST(ClosestPoint, AtBoundariesIsOnTheBoundary) {
  const LimitCase c(flat_grid(4, 4));
  const SurfaceQueries queries(c.limit);
  glm::dvec3 high = c.mesh.positions.front();
  for (const glm::dvec3& p : c.mesh.positions) high = glm::max(high, p);
  const ClosestPoint found = queries.closest(high + glm::dvec3(3, 0, 4));
  EXPECT_NEAR(found.position.x, high.x, 0.5);  // the corner is rounded
  EXPECT_GE(found.distance, 5);
  const ClosestPoint beside = queries.closest({high.x + 3, 0.5 * high.y, 4});
  EXPECT_NEAR(beside.position.x, high.x, 1e-12);
  EXPECT_NEAR(beside.distance, 5, 1e-12);
}

TEST(ClosestPoint, ManyAtOnceAreTheSameBitsForEveryThreadCount) {
  const LimitCase c(random_closed_mesh(5));
  const SurfaceQueries queries(c.limit);
  std::mt19937 random(14);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 500; ++i)
    points.push_back(1.1 * c.limit.evaluate(c.any_place(random)).position);
  std::vector<ClosestPoint> one(points.size()), many(points.size());
  {
    const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                              1);
    queries.closest(points, one);
  }
  queries.closest(points, many);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(one[i].position, many[i].position);
    ASSERT_EQ(one[i].at.face, many[i].at.face);
  }
}

TEST(ClosestPoint, DistancesAreItsOwn) {
  const LimitCase c(random_closed_mesh(5));
  const SurfaceQueries queries(c.limit);
  std::mt19937 random(15);
  std::vector<glm::dvec3> points{{1e90, 0, 0}, {0, 1e200, 1e200}};
  for (int i = 0; i < 500; ++i)
    points.push_back((0.9 + 0.001 * i) * c.limit.evaluate(c.any_place(random)).position);
  std::vector<double> distances(points.size());
  queries.distances(points, distances);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double wanted = queries.closest(points[i]).distance;
    ASSERT_NEAR(distances[i], wanted, 1e-14 * (1 + wanted)) << i;
  }
  EXPECT_THAT(message_of(ErrorCode::InvalidArgument,
                         [&] { queries.distances(points, std::span(distances).first(3)); }),
              HasSubstr("room for 3 answers"));
}

// In units of a small surface such points have no finite coordinates.
TEST(ClosestPoint, FromTheFarthestPlacesIsThatOfItsDirection) {
  PolygonMesh small = cube();
  for (glm::dvec3& p : small.positions) p = 1e-3 * p + glm::dvec3(1, 2, 3);
  const LimitCase c(small);
  const SurfaceQueries queries(c.limit);
  for (const glm::dvec3 direction :
       {glm::dvec3(1, 0.5, 0.25), glm::dvec3(-0.75, 0.5, 1), glm::dvec3(0, 0, -1)}) {
    const ClosestPoint far = queries.closest(1e307 * direction);
    const ClosestPoint near = queries.closest(1e90 * direction);
    EXPECT_EQ(far.position, near.position);
    EXPECT_NEAR(far.distance, 1e307 * glm::length(direction), 1e293);
  }
}

TEST(SurfaceQueries, BadQuestionsAreRefused) {
  const LimitCase c(cube());
  const SurfaceQueries queries(c.limit);
  const auto message = [](const auto& ask) { return message_of(ErrorCode::InvalidArgument, ask); };
  const double nan = std::nan("");
  EXPECT_THAT(message([&] { (void)queries.closest({0, nan, 0}); }), HasSubstr("not finite"));
  EXPECT_THAT(message([&] {
                (void)queries.first_hit({{0, 0, 0}, {0, 0, 0}});
              }),
              HasSubstr("no direction"));
  PolygonMesh holes = cube();
  holes.hole_faces = {0, 1, 2, 3, 4, 5};
  const LimitCase nothing(holes);
  EXPECT_THAT(message_of(ErrorCode::UnusableMesh, [&] { SurfaceQueries(nothing.limit); }),
              HasSubstr("has no faces"));
}

using Real = long double;
using Real3 = glm::vec<3, Real>;

PolygonMesh stretched(PolygonMesh mesh, double factor, const glm::dvec3& along) {
  const glm::dvec3 axis = glm::normalize(along);
  for (glm::dvec3& p : mesh.positions) p += (factor - 1) * glm::dot(axis, p) * axis;
  return mesh;
}

struct Stretch {
  double factor;
  glm::dvec3 along;
};
const std::vector<Stretch> kStretches = {{1e2, {1, 0, 0}},     {1e2, {0, 0, 1}}, {1e2, {1, 1, 0.3}},
                                         {1e4, {1, 0, 0}},     {1e4, {0, 1, 0}}, {1e4, {0, 0, 1}},
                                         {1e4, {1, 0.7, 0.4}}, {1e4, {1, -1, 1}}};

// Meshes with the surfaces through them, in unit coordinates.
std::vector<NamedMesh> shapes() {
  return {{"torus", torus(16, 10, 2, 1)},
          {"icosphere", icosphere(2)},
          {"closed", random_closed_mesh(3)}};
}

// A surface that is asked, and how much its questions take.
struct Asked {
  explicit Asked(const PolygonMesh& mesh, InterpolationMethod method)
      : fitted(fit_mesh(mesh, "mesh", *make_cpu_backend(),
                        {.method = method, .repairs = false, .quads = QuadChoice::Off})),
        surface(fitted_surface(fitted.mesh, fitted.fit, fitted.evaluate_options())),
        limit(std::shared_ptr<const DooSabinSurface>(std::move(surface))),
        tree(limit) {}

  template <class Random>
  [[nodiscard]] glm::dvec3 any_place(Random& random) const {
    std::uniform_int_distribution<std::int32_t> corner(0, limit.topology().corner_count() - 1);
    std::uniform_real_distribution<double> within(0, 1);
    LimitSurface::Corner at(limit);
    at.move_to(corner(random));
    const double u = within(random);
    return at.at({u, within(random)}).position;
  }

  FittedMesh fitted;
  std::unique_ptr<const DooSabinSurface> surface;
  LimitSurface limit;
  CornerTree tree;
};

// Newton's method from a place of a patch, as far as that goes down, in long double and by ways on
// the surface; knows nothing of boxes, bounds or trees.
Real descended(LimitSurface::Corner& corner, Real u, Real v, const glm::dvec3& point) {
  const auto at = [&](Real a, Real b) {
    return corner.at({static_cast<double>(a), static_cast<double>(b)});
  };
  const auto square = [&](const PatchPoint& p) {
    const Real3 off = Real3(p.position) - Real3(point);
    return glm::dot(off, off);
  };
  PatchPoint here = at(u, v);
  Real best = square(here), damping = 0;
  for (int step = 0; step < 80; ++step) {
    const Real3 off = Real3(here.position) - Real3(point), su(here.du), sv(here.dv);
    const Real e = glm::dot(su, su), f = glm::dot(su, sv), g = glm::dot(sv, sv);
    const Real a = e * (1 + damping), c = g * (1 + damping), det = a * c - f * f;
    const Real gu = glm::dot(off, su), gv = glm::dot(off, sv);
    const Real nu = std::clamp<Real>(u - (c * gu - f * gv) / det, 0, 1);
    const Real nv = std::clamp<Real>(v - (a * gv - f * gu) / det, 0, 1);
    const PatchPoint next = at(nu, nv);
    if (const Real value = square(next); value < best) {
      best = value;
      u = nu;
      v = nv;
      here = next;
      damping /= 10;
    } else {
      damping = std::max<Real>(damping * 10, 1e-12L);
    }
  }
  return std::sqrt(best);
}

// From all places of a grid that are among the nearest few, as they lie and by what is left of them
// across the stretch.
Real nearest_by_samples(const Asked& asked, const glm::dvec3& point, const glm::dvec3& along) {
  const glm::dvec3 axis = glm::normalize(along);
  struct Start {
    double order;
    std::int32_t corner;
    double u, v;
  };
  std::vector<Start> near, across;
  LimitSurface::Corner corner(asked.limit);
  constexpr int kRows = 6;
  for (std::int32_t c = 0; c < asked.limit.topology().corner_count(); ++c) {
    corner.move_to(c);
    for (int i = 0; i <= kRows * kRows + 2 * kRows; ++i) {
      const double u = double(i % (kRows + 1)) / kRows, v = double(i / (kRows + 1)) / kRows;
      const glm::dvec3 off = corner.at({u, v}).position - point;
      const double part = glm::dot(off, axis);
      near.push_back({glm::dot(off, off), c, u, v});
      across.push_back({1e6 * (glm::dot(off, off) - part * part) + part * part, c, u, v});
    }
  }
  Real least = 1e300L;
  for (auto* starts : {&near, &across}) {
    const auto few = starts->begin() + 12;
    std::ranges::partial_sort(*starts, few, {}, &Start::order);
    for (auto start = starts->begin(); start != few; ++start) {
      corner.move_to(start->corner);
      least = std::min(least, descended(corner, start->u, start->v, point));
    }
  }
  return least;
}

// The work by what a search counts, on whatever machine.
TEST(Stretched, ClosestPointsTakeLittleMoreAndAreExact) {
  constexpr int kEach = 12;
  for (const auto& [name, mesh] : shapes()) {
    for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
      // Questions to one surface: what one takes.
      const auto ask = [&](const Asked& asked, double off, const glm::dvec3& along) {
        std::mt19937 random(7);
        std::normal_distribution<double> normal;
        NearestSearch search(asked.tree);
        std::int64_t work = 0;
        for (int i = 0; i < kEach; ++i) {
          const glm::dvec3 on = asked.any_place(random);
          const double x = normal(random), y = normal(random);
          const glm::dvec3 point = on + off * glm::dvec3(x, y, normal(random));
          const NearestPlace found = search.run(point);
          work += search.work();
          const double distance = std::sqrt(found.square_distance);
          EXPECT_LE(distance, glm::distance(on, point) + 1e-13) << i;
          if (i < 3 && off > 0) {
            EXPECT_LE(distance, nearest_by_samples(asked, point, along) + 1e-13) << i;
          }
          LimitSurface::Corner corner(asked.limit);
          corner.move_to(found.corner);
          EXPECT_NEAR(glm::distance(corner.at({found.u, found.v}).position, point), distance,
                      1e-15);
        }
        return static_cast<double>(work) / kEach;
      };
      const Asked plain(mesh, method);
      for (const double off : {0.0, 1e-5, 1e-2, 0.3}) {
        const double once = ask(plain, off, {1, 0, 0});
        for (const Stretch& stretch : kStretches) {
          const Asked asked(stretched(mesh, stretch.factor, stretch.along), method);
          SCOPED_TRACE(name + " " + std::to_string(stretch.factor) + " off " + std::to_string(off));
          EXPECT_LE(ask(asked, off, stretch.along), 20 * once);
        }
      }
    }
  }
}

// At a place of the surface from wherever: that place is among the hits, and none is missed on the
// way in or out.
TEST(Stretched, RaysMeetWhatTheyAreAimedAt) {
  for (const auto& [name, mesh] : shapes()) {
    for (const Stretch& stretch : kStretches) {
      SCOPED_TRACE(name + " " + std::to_string(stretch.factor));
      const Asked asked(stretched(mesh, stretch.factor, stretch.along),
                        InterpolationMethod::Progressive);
      const SurfaceQueries queries(asked.limit);
      const Placement& placement = asked.limit.surface().placement();
      std::mt19937 random(3);
      std::normal_distribution<double> normal;
      for (int i = 0; i < 12; ++i) {
        const glm::dvec3 target = asked.any_place(random);
        const double x = normal(random), y = normal(random);
        const glm::dvec3 from = target + 3.0 * glm::normalize(glm::dvec3(x, y, normal(random)));
        const SurfaceRay ray{placement.to_model(from),
                             placement.to_model(target) - placement.to_model(from)};
        double nearest = 1e300;
        const std::vector<SurfaceHit> hits = queries.all_hits(ray);
        for (const SurfaceHit& hit : hits) nearest = std::min(nearest, std::abs(hit.t - 1));
        EXPECT_LT(nearest, 1e-9) << i;
        EXPECT_EQ(hits.size() % 2, 0) << i;
      }
    }
  }
}

}  // namespace
}  // namespace planish::test
