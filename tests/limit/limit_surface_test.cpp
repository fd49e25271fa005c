#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <opensubdiv/bfr/parameterization.h>

#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <memory>
#include <random>

#include "limit/limit_case.h"
#include "planish/measure/figures.h"
#include "planish/mend/repair.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/pipeline/fit.h"
#include "planish/queries/limit_surface.h"
#include "planish/solve/backend.h"
#include "support/calls.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

// Parameters of faces are OpenSubdiv's.

using OpenSubdiv::Bfr::Parameterization;
using ::testing::HasSubstr;

TEST(SurfaceParameter, IsThatOfOpenSubdiv) {
  for (int m = 3; m <= 30; ++m) {
    const MeshTopology topology(single_polygon(m));
    const Parameterization theirs(OpenSubdiv::Sdc::SCHEME_CATMARK, m);
    for (int i = 0; i < m; ++i) {
      double vertex[2], edge[2], centre[2];
      theirs.GetVertexCoord(i, vertex);
      theirs.GetEdgeCoord(i, 0.25, edge);
      theirs.GetCenterCoord(centre);
      const SurfaceParameter v = surface_parameter(topology, i, 0, 0);
      const SurfaceParameter e = surface_parameter(topology, i, 0.5, 0);
      const SurfaceParameter f = surface_parameter(topology, i, 1, 1);
      EXPECT_NEAR(v.u, vertex[0], 1e-15);
      EXPECT_NEAR(v.v, vertex[1], 1e-15);
      EXPECT_NEAR(e.u, edge[0], 1e-15);
      EXPECT_NEAR(e.v, edge[1], 1e-15);
      if (m != 4 && i != 0) continue;  // theirs names the centre once
      EXPECT_NEAR(f.u, centre[0], 1e-15) << m << " " << i;
      EXPECT_NEAR(f.v, centre[1], 1e-15);
    }
  }
}

TEST(SurfaceParameter, ComesBackFromCorners) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> within(0, 1);
  for (const int m : {3, 4, 5, 9, 10, 26}) {
    const MeshTopology topology(single_polygon(m));
    for (int i = 0; i < m; ++i) {
      const double u = within(random), v = within(random);
      const CornerParameter back = corner_parameter(topology, surface_parameter(topology, i, u, v));
      EXPECT_EQ(back.corner, i);
      EXPECT_NEAR(back.u, u, 1e-14);
      EXPECT_NEAR(back.v, v, 1e-14);
    }
  }
}

TEST(SurfaceParameter, PlacesOutsideAreRefused) {
  const MeshTopology quad(single_polygon(4)), triangle(single_polygon(3));
  const auto message = [](const MeshTopology& topology, const SurfaceParameter& at) {
    return message_of(ErrorCode::InvalidArgument, [&] { (void)corner_parameter(topology, at); });
  };
  EXPECT_THAT(message(quad, {1, 0, 0}), HasSubstr("the mesh has 1 faces"));
  EXPECT_THAT(message(quad, {0, 1.1, 0}), HasSubstr("face 0 at (1.1, 0): lies outside the face"));
  EXPECT_THAT(message(quad, {0, 0, std::nan("")}), HasSubstr("lies outside"));
  EXPECT_THAT(message(triangle, {0, 1.2, 1.2}), HasSubstr("lies outside"));
  EXPECT_THAT(message(triangle, {0, 0.6, 0}), HasSubstr("lies outside"));
  EXPECT_NEAR(corner_parameter(quad, {0, 1 + 1e-12, 0}).v, 0, 1e-15);
}

// The tessellation's rows come from the templates, which have been held to stencil tables.
TEST(LimitSurface, PassesThroughTheTessellation) {
  for (const auto& [name, mesh] : limit_meshes()) {
    for (const Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const LimitCase c(mesh, weights);
      const SurfaceMesh surface = c.tessellated(3);
      const PatchNumbering numbering(c.surface->patches(), 3, c.surface->hidden());
      for (std::int32_t corner = 0; corner < c.limit.topology().corner_count(); ++corner) {
        if (numbering.is_hidden(c.limit.topology().face_of(corner))) continue;
        for (int i = 0; i < 25; ++i) {
          const int a = i % 5, b = i / 5;
          const auto row = static_cast<std::size_t>(numbering.row(corner, a, b));
          const SurfacePoint point =
              c.limit.evaluate(surface_parameter(c.limit.topology(), corner, a / 4.0, b / 4.0));
          ASSERT_LT(glm::length(point.position - surface.positions[row]),
                    1e-14 * c.surface->placement().diagonal)
              << corner << " " << a << " " << b;
          ASSERT_NEAR(glm::length(point.normal), 1, 1e-12);
          const double twist = glm::length(glm::cross(point.du, point.dv)) /
                               (glm::length(point.du) * glm::length(point.dv));
          const std::int32_t vertex = c.limit.topology().vertex_of(corner);
          const bool is_flat_ring =
              a == 0 && b == 0 && c.limit.topology().corners_at(vertex).size() <= 2;
          if (is_flat_ring && !c.limit.topology().is_boundary_vertex(vertex)) {
            // Tangents are parallel; the tessellation takes those of its facets.
            ASSERT_GT(glm::dot(point.normal, glm::dvec3(surface.normals[row])), 0.5);
            continue;
          }
          if (!(twist > 1e-3)) continue;  // there too, at creases
          ASSERT_LT(glm::length(point.normal - glm::dvec3(surface.normals[row])), 1e-5)
              << corner << " " << a << " " << b;
        }
      }
    }
  }
}

TEST(LimitSurface, DerivativesAreByTheFacesParameters) {
  std::mt19937 random(5);
  constexpr double h = 1e-6;
  for (const auto& [name, mesh] : limit_meshes()) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    for (int i = 0; i < 40; ++i) {
      const SurfaceParameter at = c.any_place(random);
      const CornerParameter in = corner_parameter(c.limit.topology(), at);
      if (std::min({in.u, in.v, 1 - in.u, 1 - in.v}) < 0.05) continue;
      const SurfacePoint p = c.limit.evaluate(at);
      const glm::dvec3 du = (c.limit.evaluate({at.face, at.u + h, at.v}).position -
                             c.limit.evaluate({at.face, at.u - h, at.v}).position) /
                            (2 * h);
      const glm::dvec3 dv = (c.limit.evaluate({at.face, at.u, at.v + h}).position -
                             c.limit.evaluate({at.face, at.u, at.v - h}).position) /
                            (2 * h);
      const double size = c.surface->placement().diagonal;
      ASSERT_LT(glm::length(du - p.du), 1e-3 * size) << at.face << " " << at.u << " " << at.v;
      ASSERT_LT(glm::length(dv - p.dv), 1e-3 * size) << at.face << " " << at.u << " " << at.v;
      ASSERT_GT(glm::dot(glm::cross(p.du, p.dv), p.normal), 0.0);
    }
  }
}

TEST(LimitSurface, CurvatureIsThatOfAParaboloid) {
  constexpr double kA = 0.3, kB = -0.2;
  PolygonMesh mesh = flat_grid(8, 8);
  for (glm::dvec3& p : mesh.positions) p.z = 0.5 * (kA * p.x * p.x + kB * p.y * p.y);
  const LimitCase c(mesh);
  std::mt19937 random(6);
  int inside = 0;
  glm::dvec3 low = mesh.positions.front(), high = low;
  for (const glm::dvec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
  for (int i = 0; i < 300; ++i) {
    const SurfacePoint p = c.limit.evaluate(c.any_place(random));
    if (p.position.x < low.x + 2.1 || p.position.x > high.x - 2.1 || p.position.y < low.y + 2.1 ||
        p.position.y > high.y - 2.1)
      continue;
    ++inside;
    const double zx = kA * p.position.x, zy = kB * p.position.y, w = 1 + zx * zx + zy * zy;
    const PointCurvature curvature = p.curvature();
    ASSERT_TRUE(curvature.is_known);
    ASSERT_NEAR(curvature.gaussian, kA * kB / (w * w), 1e-12);
    const double mean = -0.5 * ((1 + zy * zy) * kA + (1 + zx * zx) * kB) / std::pow(w, 1.5);
    ASSERT_NEAR(curvature.mean, p.normal.z > 0 ? mean : -mean, 1e-12);
    ASSERT_NEAR(curvature.largest * curvature.smallest, curvature.gaussian, 1e-12);
    ASSERT_NEAR(glm::dot(curvature.largest_direction, p.normal), 0, 1e-12);
    ASSERT_NEAR(glm::dot(curvature.largest_direction, curvature.smallest_direction), 0, 1e-12);
  }
  EXPECT_GT(inside, 50);
}

TEST(LimitSurface, SaysWhereSecondDerivativesHaveNoLimit) {
  const LimitCase c(cube());
  const SurfacePoint vertex = c.limit.evaluate({0, 0, 0});
  EXPECT_FALSE(vertex.has_second);
  EXPECT_FALSE(vertex.curvature().is_known);
  EXPECT_EQ(vertex.duu, glm::dvec3(0.0));
  EXPECT_TRUE(c.limit.evaluate({0, 0.25, 0.25}).has_second);
  EXPECT_TRUE(c.limit.evaluate({0, 0.5, 0.5}).has_second);  // a face of four
  EXPECT_TRUE(LimitCase(torus(8, 6, 2, 1)).limit.evaluate({3, 0, 0}).has_second);
}

// However near to a vertex or centre where no polynomial ends.
TEST(LimitSurface, NormalsAreAcrossTheDerivatives) {
  for (const auto& mesh : {icosphere(1), prism(7)}) {
    const LimitCase c(mesh);
    for (std::int32_t corner = 0; corner < c.limit.topology().corner_count(); ++corner) {
      for (int halvings = 1; halvings < 24; ++halvings) {
        const double t = std::ldexp(1.0, -halvings);
        for (const auto& [u, v] : {std::pair{t, 0.3 * t}, {1 - 0.7 * t, 1 - t}}) {
          const SurfacePoint p =
              c.limit.evaluate(surface_parameter(c.limit.topology(), corner, u, v));
          const glm::dvec3 across = glm::normalize(glm::cross(p.du, p.dv));
          ASSERT_LT(glm::length(across - p.normal), 1e-12) << corner << " " << halvings;
        }
      }
    }
  }
}

TEST(LimitSurface, StencilsGiveTheSamePoint) {
  std::mt19937 random(8);
  for (const auto& [name, mesh] : limit_meshes()) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    for (int i = 0; i < 30; ++i) {
      const SurfaceParameter at = c.any_place(random);
      const SurfaceStencil stencil = c.limit.stencil(at);
      const SurfacePoint point = c.limit.evaluate(at);
      glm::dvec3 position(0.0), du(0.0), dv(0.0);
      for (std::size_t k = 0; k < stencil.points.size(); ++k) {
        const glm::dvec3 p = c.surface->state()[stencil.points[k]];
        position += stencil.position[k] * p;
        du += stencil.du[k] * p;
        dv += stencil.dv[k] * p;
      }
      const Placement& placement = c.surface->placement();
      ASSERT_LT(glm::length(placement.to_model(position) - point.position),
                1e-13 * placement.diagonal);
      ASSERT_LT(glm::length(placement.diagonal * du - point.du), 1e-9 * placement.diagonal);
      ASSERT_LT(glm::length(placement.diagonal * dv - point.dv), 1e-9 * placement.diagonal);
    }
  }
}

TEST(LimitSurface, ManyAtOnceAreTheSameBitsForEveryThreadCount) {
  const LimitCase c(random_closed_mesh(4));
  std::mt19937 random(9);
  std::vector<SurfaceParameter> places;
  for (int i = 0; i < 3000; ++i) places.push_back(c.any_place(random));
  std::vector<SurfacePoint> one(places.size()), many(places.size());
  {
    const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                              1);
    c.limit.evaluate(places, one);
  }
  c.limit.evaluate(places, many);
  for (std::size_t i = 0; i < places.size(); ++i) {
    ASSERT_EQ(one[i].position, many[i].position);
    ASSERT_EQ(one[i].duv, many[i].duv);
    ASSERT_EQ(one[i].position, c.limit.evaluate(places[i]).position);
  }
  EXPECT_THAT(message_of(ErrorCode::InvalidArgument,
                         [&] { c.limit.evaluate(places, std::span(one).first(1)); }),
              ::testing::HasSubstr("3000 places, and room for 1"));
}

}  // namespace
}  // namespace planish::test

namespace planish {
namespace {

constexpr std::size_t kEdges = test::kBentEdges;

double gap_of(const PolygonMesh& mesh, const RepairedMesh& repaired, InterpolationMethod method) {
  const auto backend = make_cpu_backend({Precision::Double});
  FitOptions options;
  options.method = method;
  options.tolerance = 1e-10;
  const Fit fitted = fit(mesh, *backend, options);
  return sheet_gap(LimitSurface(fitted_surface(mesh, fitted)), repaired.source_vertices,
                   repaired.separated_edges) /
         fitted.placement.diagonal;
}

TEST(SheetGap, IsClosedByCornersAndSeenWithoutThem) {
  const RepairedMesh repaired = repair(test::bent_sheets());
  ASSERT_EQ(repaired.separated_edges.size(), kEdges);
  PolygonMesh smooth = repaired.mesh;
  smooth.corners.clear();
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    EXPECT_LT(gap_of(repaired.mesh, repaired, method), 1e-9);
    EXPECT_GT(gap_of(smooth, repaired, method), 1e-4);
  }
}

// Squares whose corners are corners: their boundaries are their edges.
TEST(SheetGap, IsTheDistanceOfTheCurves) {
  RepairedMesh copies;
  PolygonMesh& mesh = copies.mesh;
  for (const double z : {0.0, 0.25, 0.1}) {
    const std::int32_t first = mesh.vertex_count();
    mesh.positions.insert(mesh.positions.end(), {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}});
    mesh.add_face(std::array{first, first + 1, first + 2, first + 3});
    copies.source_vertices.insert(copies.source_vertices.end(), {0, 1, first + 2, first + 3});
  }
  mesh.positions.push_back({7, 7, 7});  // of no face
  copies.source_vertices.push_back(12);
  for (std::int32_t v = 0; v < 12; ++v) mesh.corners.push_back({v});
  const EvaluateOptions options;
  const LimitSurface surface(std::make_shared<const DooSabinSurface>(mesh, options));
  const auto gap = [&](std::vector<std::pair<std::int32_t, std::int32_t>> edges) {
    return sheet_gap(surface, copies.source_vertices, edges);
  };
  EXPECT_NEAR(gap({{0, 1}}), 0.25, 1e-12);
  EXPECT_EQ(gap({{2, 3}}), 0) << "of one sheet only";
  EXPECT_EQ(gap({}), 0);
}

}  // namespace
}  // namespace planish
