#include "planish/measure/vertex_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/work.h"
#include "support/meshes.h"

namespace planish {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

SurfaceMesh surface_at(const PolygonMesh& mesh) {
  SurfaceMesh surface;
  surface.positions = mesh.positions;
  surface.face_offsets = mesh.face_offsets;
  surface.face_vertices = mesh.face_vertices;
  return surface;
}

// On a sphere every chord shows the same curvature, whatever the mesh.
TEST(NormalCurvatures, AreExactOnASphere) {
  for (const double radius : {1.0, 4.0}) {
    SurfaceMesh surface = surface_at(test::icosphere(2));
    for (glm::dvec3& position : surface.positions) {
      surface.normals.emplace_back(position);
      position *= radius;
    }
    const Curvatures curvatures = curvatures_of_normals(surface);
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      EXPECT_NEAR(curvatures.mean[v], 1 / radius, 1e-5 / radius);
      EXPECT_NEAR(curvatures.gaussian[v], 1 / (radius * radius), 1e-5 / (radius * radius));
    }
  }
}

// Of a large face few corners are asked, neighbours among them: a sphere cut by two planes.
TEST(NormalCurvatures, AreExactAtLargeFaces) {
  for (const int n : {10, 34, 2000}) {
    PolygonMesh drum = test::prism(n);
    for (glm::dvec3& p : drum.positions) p = glm::normalize(p + glm::dvec3(0, 0, 0.1));
    SurfaceMesh surface = surface_at(drum);
    for (const glm::dvec3& position : surface.positions) surface.normals.emplace_back(position);
    const std::atomic<std::int64_t>& pairs = work_counts[static_cast<std::size_t>(Work::Pairs)];
    const std::int64_t before = pairs;
    const Curvatures curvatures = curvatures_of_normals(surface);
    EXPECT_LE(pairs - before, 32 * static_cast<std::int64_t>(drum.face_vertices.size())) << n;
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      // Neighbours of the largest are 0.003 apart, of normals in single precision.
      EXPECT_NEAR(curvatures.mean[v], 1, 2e-4) << n;
      EXPECT_NEAR(curvatures.gaussian[v], 1, 4e-4) << n;
    }
  }
}

TEST(NormalCurvatures, TurningTheNormalsOverTurnsTheMeanOnly) {
  SurfaceMesh surface = surface_at(test::icosphere(1));
  for (const glm::dvec3& position : surface.positions) surface.normals.emplace_back(-position);
  const Curvatures curvatures = curvatures_of_normals(surface);
  EXPECT_NEAR(curvatures.mean[0], -1, 1e-5);
  EXPECT_NEAR(curvatures.gaussian[0], 1, 1e-5);
}

// A torus of radii R and r: 1/r across the tube, cos(t) / (R + r cos(t)) along it.
double torus_error(int n) {
  constexpr double kMajor = 2, kMinor = 1;
  SurfaceMesh surface = surface_at(test::torus(2 * n, n, kMajor, kMinor));  // around z
  std::vector<double> cosines;
  for (const glm::dvec3& p : surface.positions) {
    const double ring = std::hypot(p.x, p.y);
    const glm::dvec3 centre = glm::dvec3(p.x, p.y, 0) * (kMajor / ring);
    const glm::dvec3 normal = glm::normalize(p - centre);
    surface.normals.emplace_back(normal);
    cosines.push_back((ring - kMajor) / kMinor);
  }
  const Curvatures curvatures = curvatures_of_normals(surface);
  double error = 0;
  for (std::size_t v = 0; v < cosines.size(); ++v) {
    const double along = cosines[v] / (kMajor + kMinor * cosines[v]);
    error = std::max(error, std::abs(curvatures.mean[v] - (1 / kMinor + along) / 2));
    error = std::max(error, std::abs(curvatures.gaussian[v] - along / kMinor));
  }
  return error;
}

TEST(NormalCurvatures, ComeNearerToATorusWithTheSquareOfTheFaces) {
  const double coarse = torus_error(16), fine = torus_error(32);
  EXPECT_LT(coarse, 0.05);
  EXPECT_LT(fine, coarse / 3.5);
}

TEST(NormalCurvatures, AreZeroWhereNothingIsKnown) {
  SurfaceMesh surface = surface_at(test::flat_grid(2, 2));
  surface.normals.assign(surface.positions.size(), glm::vec3(0, 0, 1));
  surface.positions.emplace_back(9, 9, 9);  // of no face
  surface.normals.emplace_back(1, 0, 0);
  const Curvatures curvatures = curvatures_of_normals(surface);
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    EXPECT_EQ(curvatures.mean[v], 0);
    EXPECT_EQ(curvatures.gaussian[v], 0);
  }
}

// The integral of the Gaussian curvature over a sphere-like surface is 4 pi, whatever its shape.
TEST(NormalCurvatures, KeepGaussAndBonnetOnAnEllipsoid) {
  SurfaceMesh surface = surface_at(test::icosphere(4));
  const glm::dvec3 axes(1.5, 1, 0.8);
  for (glm::dvec3& position : surface.positions) {
    surface.normals.emplace_back(glm::normalize(position / axes));
    position *= axes;
  }
  const Curvatures curvatures = curvatures_of_normals(surface);
  double integral = 0;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    const double area =
        glm::length(glm::cross(surface.positions[face[1]] - surface.positions[face[0]],
                               surface.positions[face[2]] - surface.positions[face[0]])) /
        2;
    for (const std::int32_t v : face) integral += curvatures.gaussian[v] * area / 3;
  }
  EXPECT_NEAR(integral, 4 * kHalfTurn, 0.02 * 4 * kHalfTurn);
}

}  // namespace
}  // namespace planish
