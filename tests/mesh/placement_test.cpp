#include "planish/mesh/polygon_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mesh/test_meshes.h"

namespace planish {
namespace {

TEST(Placement, CentresAndScalesTheUsedVertices) {
  PolygonMesh mesh = test::mesh_of(0, {{0, 1, 2}});
  mesh.positions = {{1, 2, 3}, {3, 2, 3}, {3, 5, 9}, {100, 100, 100}};
  const Placement placement = placement_of(mesh);
  EXPECT_EQ(placement.centre, glm::dvec3(2, 3.5, 6));
  EXPECT_EQ(placement.diagonal, 7.0);  // 2, 3, 6: a Pythagorean quadruple
  EXPECT_EQ(placement.to_unit({3, 5, 9}), glm::dvec3(1, 1.5, 3) / 7.0);
  EXPECT_EQ(placement.to_model(glm::dvec3(0.5)), glm::dvec3(5.5, 7, 9.5));
}

TEST(Placement, CoincidingVerticesGetDiagonalOne) {
  PolygonMesh mesh = test::mesh_of(0, {{0, 1, 2}});
  mesh.positions.assign(3, {4, 5, 6});
  EXPECT_EQ(placement_of(mesh).diagonal, 1.0);
  EXPECT_EQ(placement_of(mesh).centre, glm::dvec3(4, 5, 6));
}

TEST(Placement, MeshWithoutFacesIsLeftInPlace) {
  EXPECT_EQ(placement_of(PolygonMesh{}).diagonal, 1.0);
  EXPECT_EQ(placement_of(PolygonMesh{}).centre, glm::dvec3(0.0));
}

TEST(Placement, NeitherOverflowsNorUnderflows) {
  for (const double scale : {1e150, 1e-200}) {
    PolygonMesh mesh = test::mesh_of(0, {{0, 1, 2}});
    mesh.positions = {{-scale, 0, 0}, {scale, 0, 0}, {0, scale, 0}};
    const double expected = std::sqrt(5.0) * scale;
    EXPECT_NEAR(placement_of(mesh).diagonal / expected, 1.0, 1e-15);
  }
}

}  // namespace
}  // namespace planish
