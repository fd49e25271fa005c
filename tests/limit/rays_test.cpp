#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "limit/limit_case.h"
#include "limit/long_run.h"
#include "planish/queries/surface_queries.h"

namespace planish::test {
namespace {

template <class Random>
glm::dvec3 any_direction(Random& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random);
  return glm::normalize(glm::dvec3(x, y, normal(random)));
}

TEST(SurfaceRays, HitsLieOnTheSurfaceAndOnTheRay) {
  std::mt19937 random(21);
  int hits = 0;
  for (const auto& [name, mesh] : limit_meshes()) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const double size = c.surface->placement().diagonal;
    for (int i = 0; i < 20; ++i) {
      const SurfacePoint on = c.limit.evaluate(c.any_place(random));
      const glm::dvec3 direction = any_direction(random);
      const SurfaceRay ray{on.position - size * direction, 2.0 * direction};
      const auto all = queries.all_hits(ray);
      double nearest = 1e300;
      double last = -1;
      for (const SurfaceHit& hit : all) {
        ++hits;
        ASSERT_GE(hit.t, last);
        last = hit.t;
        ASSERT_LT(glm::length(ray.origin + hit.t * ray.direction - hit.position), 1e-10 * size);
        ASSERT_LT(glm::length(c.limit.evaluate(hit.at).position - hit.position), 1e-14 * size);
        nearest = std::min(nearest, std::abs(hit.t - 0.5 * size));
      }
      const bool is_steep = std::abs(glm::dot(on.normal, direction)) > 1e-3;
      const bool is_hidden =
          !c.surface->hidden().empty() || glm::length(glm::cross(on.du, on.dv)) == 0;
      if (is_steep && !is_hidden) {
        ASSERT_LT(nearest, 1e-9 * size) << "the place that was aimed at";
      }
      const auto first = queries.first_hit(ray);
      ASSERT_EQ(first.has_value(), !all.empty());
      ASSERT_EQ(queries.is_occluded(ray), !all.empty());
      if (first) {
        ASSERT_NEAR(first->t, all.front().t, 1e-9);
      }
    }
  }
  EXPECT_GT(hits, 500);
}

// Through a closed surface as often in as out.
TEST(SurfaceRays, EnterClosedSurfacesAsOftenAsTheyLeave) {
  std::mt19937 random(22);
  int tangent = 0, rays = 0;
  const int each = run_length(10'000) / 5;  // PLANISH_LONG_RUN=1000000 sends as many
  for (const auto& mesh :
       {cube(), torus(8, 6, 2, 1), icosphere(1), random_closed_mesh(2), random_closed_mesh(7)}) {
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const double size = c.surface->placement().diagonal;
    for (int i = 0; i < each; ++i, ++rays) {
      const glm::dvec3 through = c.surface->placement().centre + 0.4 * size * any_direction(random);
      const glm::dvec3 direction = any_direction(random);
      const auto hits = queries.all_hits({through - 3 * size * direction, direction});
      int entered = 0, touched = 0;
      for (const SurfaceHit& hit : hits) {
        touched += hit.is_tangent ? 1 : 0;
        entered += glm::dot(hit.normal, direction) < 0 ? 1 : -1;
      }
      tangent += touched;
      if (touched == 0) {
        ASSERT_EQ(hits.size() % 2, 0u) << i;
        ASSERT_EQ(entered, 0) << i;
      }
    }
  }
  RecordProperty("tangent", tangent);
  EXPECT_LT(tangent, rays / 1000);
}

// Which it does over many of a patch's smallest pieces, seen from their edge.
TEST(SurfaceRays, AlongTheSurfaceTouchIt) {
  std::mt19937 random(23);
  for (const auto& mesh : {cube(), torus(8, 6, 2, 1), random_closed_mesh(2)}) {
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const double size = c.surface->placement().diagonal;
    for (int i = 0; i < 40; ++i) {
      const SurfacePoint on = c.limit.evaluate(c.any_place(random));
      const double angle = 0.37 * i;
      const glm::dvec3 along = glm::normalize(std::cos(angle) * on.du + std::sin(angle) * on.dv);
      double nearest = 1e300;
      for (const SurfaceHit& hit : queries.all_hits({on.position - 2 * size * along, along})) {
        if (hit.is_tangent) nearest = std::min(nearest, glm::length(hit.position - on.position));
      }
      EXPECT_LT(nearest, 1e-4 * size) << i;
    }
  }
}

// At vertices, edges and centres, where many patches meet: each place once.
TEST(SurfaceRays, BordersOfPatchesAreHitOnce) {
  for (const auto& mesh : {cube(), torus(8, 6, 2, 1), icosphere(1), dodecahedron()}) {
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const double size = c.surface->placement().diagonal;
    for (std::int32_t corner = 0; corner < c.limit.topology().corner_count(); ++corner) {
      for (const auto& [u, v] :
           {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.5, 0.0}, {0.5, 0.5}}) {
        const SurfacePoint on =
            c.limit.evaluate(surface_parameter(c.limit.topology(), corner, u, v));
        const SurfaceRay ray{on.position + 0.01 * size * on.normal, -on.normal, 0, 0.02 * size};
        const auto hits = queries.all_hits(ray);
        ASSERT_EQ(hits.size(), 1u) << corner << " " << u << " " << v;
        ASSERT_NEAR(hits[0].t, 0.01 * size, 1e-7 * size);
      }
    }
  }
}

TEST(SurfaceRays, RangesCut) {
  const LimitCase c(torus(12, 8, 2, 1));
  const SurfaceQueries queries(c.limit);
  const glm::dvec3 from(-10, 0.01, 0.02), along(1, 0, 0);
  const auto all = queries.all_hits({from, along});
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(queries.all_hits({from, along, all[0].t + 1e-6, all[3].t - 1e-6}).size(), 2u);
  EXPECT_FALSE(queries.is_occluded({from, along, 0, all[0].t - 1e-6}));
  EXPECT_NEAR(queries.first_hit({from, along, all[0].t + 1e-6})->t, all[1].t, 1e-12);
}

}  // namespace
}  // namespace planish::test
