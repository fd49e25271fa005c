#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "limit/limit_case.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/queries/closest_point.h"
#include "planish/queries/surface_queries.h"

namespace planish::test {
namespace {

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
