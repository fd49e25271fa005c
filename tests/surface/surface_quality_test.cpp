#include "planish/surface/quality_sum.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/measure/figures.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"

namespace planish {
namespace {

constexpr double kPi = std::numbers::pi;

// The mesh itself as a surface.
SurfaceMesh surface_with(const PolygonMesh& mesh, const std::vector<glm::vec3>& normals) {
  SurfaceMesh surface;
  surface.level = 0;
  surface.positions = mesh.positions;
  surface.face_offsets = mesh.face_offsets;
  surface.face_vertices = mesh.face_vertices;
  surface.normals = normals;
  return surface;
}

// Two squares of area 1 and 3 in the plane z = 0.
PolygonMesh two_squares() {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {4, 0, 0}, {4, 1, 0}};
  mesh.add_face(std::array{0, 1, 2, 3});
  mesh.add_face(std::array{1, 4, 5, 2});
  return mesh;
}

TEST(SurfaceQuality, AFacesAreaIsSharedAmongItsCorners) {
  const PolygonMesh mesh = two_squares();
  std::vector<glm::vec3> normals(6, glm::vec3(0, 0, 1));
  normals[4] = glm::vec3(0, 0, -1);
  const SurfaceQuality quality = surface_quality(surface_with(mesh, normals), mesh);
  EXPECT_DOUBLE_EQ(quality.folded_area, 0.75 / 4.0);
  EXPECT_DOUBLE_EQ(quality.max_normal_deviation, 180.0);
  EXPECT_NEAR(quality.rms_normal_deviation, 180.0 * std::sqrt(0.75 / 4.0), 1e-10);
}

// A strip of four unit squares whose last one is turned back under the third by 150 degrees.
PolygonMesh strip_with_a_fold() {
  PolygonMesh mesh;
  const double back = 3 + std::cos(150 * kPi / 180), down = -std::sin(150 * kPi / 180);
  for (const double y : {0.0, 1.0}) {
    for (int x = 0; x < 4; ++x) mesh.positions.emplace_back(x, y, 0);
    mesh.positions.emplace_back(back, y, down);
  }
  for (int x = 0; x < 4; ++x) mesh.add_face(std::array{x, x + 1, x + 6, x + 5});
  return mesh;
}

TEST(SurfaceQuality, TellsFoldsOfTheInputFromOthers) {
  const PolygonMesh mesh = strip_with_a_fold();
  // Turned over: one corner of the first square, one of the third, beside the folded edge.
  std::vector<glm::vec3> normals(10, glm::vec3(0, 0, 1));
  normals[0] = normals[8] = normals[9] = normals[4] = glm::vec3(0, 0, -1);
  const SurfaceQuality quality = surface_quality(surface_with(mesh, normals), mesh);
  EXPECT_DOUBLE_EQ(quality.folded_area_elsewhere, 0.25 / 4);
  EXPECT_GT(quality.folded_area, 0.25 / 4 + 0.2 / 4);
  // Those that the input is not to blame for are named first.
  ASSERT_EQ(quality.folded_places.size(), 1u);
  EXPECT_EQ(quality.folded_places[0].face, 0);
  EXPECT_EQ(quality.folded_places[0].position, mesh.positions[0]);
  normals[0] = glm::vec3(0, 0, 1);
  const SurfaceQuality beside = surface_quality(surface_with(mesh, normals), mesh);
  EXPECT_EQ(beside.folded_area_elsewhere, 0.0);
  ASSERT_EQ(beside.folded_places.size(), 2u);
  EXPECT_EQ(beside.folded_places[0].face, 2);
  EXPECT_EQ(beside.folded_places[1].face, 3);
  const std::vector<std::uint8_t> expected = {0, 0, 1, 1};
  EXPECT_EQ(beside_folds(surface_with(mesh, normals), mesh), expected);
}

// Of level 1 of the surface of a cage, by blocks as by the mesh that they make.
SurfaceQuality quality_both_ways(const PolygonMesh& cage, const PolygonMesh& reference) {
  const DooSabinSurface base(cage, {});
  const auto blocks = base.level(1);
  const SurfaceQuality of_blocks =
      surface_quality(*blocks, reference, folded_edges(reference).is_beside, {});
  const SurfaceQuality of_mesh = surface_quality(collect(*blocks, {}), reference);
  EXPECT_NEAR(of_blocks.rms_normal_deviation, of_mesh.rms_normal_deviation, 1e-6);
  EXPECT_NEAR(of_blocks.max_normal_deviation, of_mesh.max_normal_deviation, 1e-6);
  EXPECT_NEAR(of_blocks.folded_area, of_mesh.folded_area, 1e-9);
  EXPECT_NEAR(of_blocks.folded_area_elsewhere, of_mesh.folded_area_elsewhere, 1e-9);
  return of_blocks;
}

// A bow tie in the middle of a bent plate: its corners' normals differ, and it has none itself.
TEST(SurfaceQuality, FacesWithoutAreaDeviateFromNothing) {
  PolygonMesh mesh = test::grid(
      3, 3, [](double x, double y) { return glm::dvec3(x, y, 0.4 * x * x - 0.3 * y * y); });
  mesh.positions[5] = {1, 1, 0};
  mesh.positions[6] = {2, 2, 0};
  mesh.positions[10] = {2, 1, 0};
  mesh.positions[9] = {1, 2, 0};
  ASSERT_EQ(glm::length(area_vector(mesh.positions, mesh.face(4))), 0.0);
  const SurfaceQuality quality = quality_both_ways(mesh, mesh);
  // The face is left out, though not its area.
  mesh.hole_faces = {4};
  const DooSabinSurface rest(mesh, {});
  const SurfaceQuality without = surface_quality(*rest.level(1), mesh, {}, {});
  EXPECT_NEAR(quality.max_normal_deviation, without.max_normal_deviation, 1e-6);
  EXPECT_LT(quality.folded_area, without.folded_area + 1e-9);
}

// A cone's tip has no normal: on a quad there, those beside it count.
TEST(SurfaceQuality, OfATaggedTipTheNormalsBesideItCount) {
  const PolygonMesh smooth = test::cone(32, 1.7);
  PolygonMesh tagged = smooth;
  tagged.corners = {{32, kInfiniteSharpness}};
  const double lean = std::atan(1.7) * 180 / kPi;
  const SurfaceQuality counted = quality_both_ways(tagged, smooth),
                       left_out = quality_both_ways(tagged, tagged);
  EXPECT_NEAR(counted.max_normal_deviation, lean, 0.5) << "that of the axis";
  EXPECT_LT(left_out.max_normal_deviation, 15);
  // Where creases end there, each part of the surface has its normal.
  PolygonMesh creased = tagged;
  creased.creases = {{32, 0, kInfiniteSharpness}, {32, 16, kInfiniteSharpness}};
  PolygonMesh without_tags = creased;
  without_tags.corners.clear();
  EXPECT_EQ(quality_both_ways(creased, creased).rms_normal_deviation,
            quality_both_ways(creased, without_tags).rms_normal_deviation);
}

TEST(SurfaceQuality, AnglesAreInDegreesAgainstTheGivenNormals) {
  const PolygonMesh mesh = two_squares();
  const SurfaceMesh surface = surface_with(mesh, {6, glm::vec3(0, 0, 1)});
  for (const double degrees : {0.0, 1e-4, 30.0, 89.0, 91.0}) {
    const double angle = degrees * kPi / 180;
    const SurfaceQuality quality = surface_quality(surface, [&](std::int64_t, std::int32_t) {
      return 7.0 * glm::dvec3(std::sin(angle), 0, std::cos(angle));  // any length
    });
    EXPECT_NEAR(quality.rms_normal_deviation, degrees, 1e-12);
    EXPECT_NEAR(quality.max_normal_deviation, degrees, 1e-12);
    EXPECT_EQ(quality.folded_area, degrees > 90 ? 1.0 : 0.0);
    EXPECT_EQ(quality.bending, 0.0);
  }
}

TEST(SurfaceQuality, TheReferenceIsAskedForEveryCornerInOrder) {
  const SurfaceMesh surface = surface_with(two_squares(), {6, glm::vec3(0, 0, 1)});
  std::vector<std::pair<std::int64_t, std::int32_t>> asked;
  (void)surface_quality(surface, [&](std::int64_t face, std::int32_t corner) {
    asked.emplace_back(face, corner);
    return glm::dvec3(0, 0, 1);
  });
  const std::vector<std::pair<std::int64_t, std::int32_t>> expected = {
      {0, 0}, {0, 1}, {0, 2}, {0, 3}, {1, 0}, {1, 1}, {1, 2}, {1, 3}};
  EXPECT_EQ(asked, expected);
}

// The integral of both squared principal curvatures is 8 pi on every sphere.
TEST(SurfaceQuality, BendingOfASphere) {
  for (const double radius : {1.0, 100.0}) {
    PolygonMesh mesh = test::icosphere(4);
    std::vector<glm::vec3> normals;
    for (glm::dvec3& p : mesh.positions) {
      normals.emplace_back(glm::normalize(p));
      p *= radius;
    }
    EXPECT_NEAR(surface_quality(surface_with(mesh, normals), mesh).bending, 8 * kPi,
                0.01 * 8 * kPi);
  }
}

// 4 * (integral of the squared mean curvature) - 2 * (that of the Gaussian curvature, 0); the
// first is pi^2 c^2 / sqrt(c^2 - 1) with c the ratio of the radii (Willmore 1965).
TEST(SurfaceQuality, BendingOfATorus) {
  constexpr int kAround = 192, kAcross = 96;
  const PolygonMesh mesh = test::torus(kAround, kAcross, 1.0, 0.4);
  std::vector<glm::vec3> normals;
  for (const glm::dvec3& p : mesh.positions) {
    const glm::dvec3 middle = glm::normalize(glm::dvec3(p.x, p.y, 0));
    normals.emplace_back(glm::normalize(p - middle));
  }
  const double c = 1.0 / 0.4;
  const double expected = 4 * kPi * kPi * c * c / std::sqrt(c * c - 1);
  EXPECT_NEAR(surface_quality(surface_with(mesh, normals), mesh).bending, expected,
              0.01 * expected);
}

// Two triangles along the shorter diagonal, whose normals differ at one far end alone: there it is
// half the cotangents beside that corner, times the squared difference (Pinkall & Polthier 1993).
TEST(SurfaceQuality, QuadsAreCutAlongTheirShorterDiagonalWhereverTheyStand) {
  const std::array<glm::dvec3, 4> corners = {
      {{0, 0, 0}, {4, 0, 0}, {5, 3, 0}, {1, 3, 0}}};  // from 1 to 3 it is shorter
  const glm::vec3 up(0, 0, 1), turned(0.6f, 0, 0.8f);
  // In the triangle (0, 1, 3): the angles at 1 and at 3 lie opposite the edges of corner 0.
  const auto cotangent = [](const glm::dvec3& a, const glm::dvec3& b) {
    return glm::dot(a, b) / glm::length(glm::cross(a, b));
  };
  const double expected = 0.5 * 0.4 *
                          (cotangent(corners[0] - corners[1], corners[3] - corners[1]) +
                           cotangent(corners[0] - corners[3], corners[1] - corners[3]));
  for (const glm::dvec3& moved : {glm::dvec3(0.0), glm::dvec3(-20, 30, 0), glm::dvec3(7, -2, 5)}) {
    for (std::size_t first = 0; first < 4; ++first) {
      PolygonMesh mesh;
      std::vector<glm::vec3> normals;
      for (std::size_t i = first; i < first + 4; ++i) {
        mesh.positions.push_back(corners[i % 4] + moved);
        normals.push_back(i % 4 == 0 ? turned : up);
      }
      mesh.add_face(std::array{0, 1, 2, 3});
      EXPECT_NEAR(surface_quality(surface_with(mesh, normals), mesh).bending, expected, 1e-7)
          << first;
    }
  }
}

TEST(SurfaceQuality, SliversDoNotSpoilTheBending) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, 1e-9, 0}};
  mesh.add_face(std::array{0, 1, 2});
  const auto quality = surface_quality(surface_with(mesh, {{0, 0, 1}, {0, 0, 1}, {0, 1, 0}}), mesh);
  EXPECT_EQ(quality.bending, 0.0);
}

}  // namespace
}  // namespace planish
