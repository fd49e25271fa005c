#include "planish/mesh/coarse_balls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>

#include "mesh/test_meshes.h"
#include "planish/mesh/face_areas.h"
#include "planish/mesh/merged_meshes.h"
#include "support/cone.h"

namespace planish {
namespace {

bool may_be_balls(const PolygonMesh& mesh) {
  return are_coarse_balls(mesh, MeshTopology(mesh), face_areas(mesh));
}

PolygonMesh box(const glm::dvec3& sides) {
  PolygonMesh mesh = test::cube();
  for (glm::dvec3& p : mesh.positions) p *= sides;
  return mesh;
}

PolygonMesh regular_tetrahedron() {
  PolygonMesh mesh = test::tetrahedron();
  mesh.positions = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
  return mesh;
}

PolygonMesh octahedron() {
  PolygonMesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (const int x : {0, 1})
    for (const int y : {2, 3})
      for (const int z : {4, 5}) {
        const bool is_odd = ((x + y + z) & 1) != 0;
        mesh.add_face(is_odd ? std::array{y, x, z} : std::array{x, y, z});
      }
  return mesh;
}

TEST(CoarseBalls, AreRegularSolidsAndBoxesNearThem) {
  EXPECT_TRUE(may_be_balls(test::cube()));
  EXPECT_TRUE(may_be_balls(regular_tetrahedron()));
  EXPECT_TRUE(may_be_balls(octahedron()));
  EXPECT_TRUE(may_be_balls(box({1, 1, 2})));
}

// Which way faces look says nothing of the shape.
TEST(CoarseBalls, MayBeInsideOut) {
  for (PolygonMesh mesh : {test::cube(), box({1, 1, 4})}) {
    const bool is_ball = may_be_balls(mesh);
    std::ranges::reverse(mesh.face_vertices);  // faces of four corners, each the other way round
    EXPECT_EQ(may_be_balls(mesh), is_ball);
  }
}

TEST(CoarseBalls, LongAndFlatBoxesAreNone) {
  EXPECT_FALSE(may_be_balls(box({1, 1, 4})));
  EXPECT_FALSE(may_be_balls(box({3, 3, 1})));
}

TEST(CoarseBalls, UnevenTurnsAreNone) {
  EXPECT_FALSE(may_be_balls(test::with_base(test::cone(6, 2), 6))) << "a pyramid";
  PolygonMesh roof = test::cube();
  for (glm::dvec3& p : roof.positions)
    if (p.z > 0) p.x = 0.5 + 0.2 * (p.x - 0.5);
  EXPECT_FALSE(may_be_balls(roof));
}

TEST(CoarseBalls, HaveNoHollows) {
  PolygonMesh dented = octahedron();
  dented.positions[4].z = -0.5;
  EXPECT_FALSE(may_be_balls(dented));
}

TEST(CoarseBalls, AllPartsHaveToBeSome) {
  const PolygonMesh die = test::cube(), leg = box({0.1, 0.1, 2});
  EXPECT_TRUE(may_be_balls(merged_meshes(std::array{die, die}).mesh));
  EXPECT_FALSE(may_be_balls(merged_meshes(std::array{die, leg}).mesh));
}

}  // namespace
}  // namespace planish
