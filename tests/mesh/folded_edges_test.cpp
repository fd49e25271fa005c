#include "planish/mesh/mesh_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "mesh/test_meshes.h"

namespace planish {
namespace {

using testing::ElementsAre;

// Three unit squares in a row, then one of half the width hinged to the last and turned by an
// angle.
PolygonMesh hinged_strip(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  PolygonMesh mesh;
  for (const double y : {0.0, 1.0}) {
    for (int x = 0; x < 4; ++x) mesh.positions.emplace_back(x, y, 0);
    mesh.positions.emplace_back(3 + 0.5 * std::cos(angle), y, 0.5 * std::sin(angle));
  }
  for (int x = 0; x < 4; ++x) mesh.add_face(std::array{x, x + 1, x + 6, x + 5});
  return mesh;
}

TEST(FoldedEdges, AreThoseThatTurnByMoreThan120Degrees) {
  EXPECT_EQ(folded_edges(hinged_strip(119)).count, 0);
  EXPECT_EQ(folded_edges(hinged_strip(119)).first_face, -1);
  const FoldedEdges folds = folded_edges(hinged_strip(-121));
  EXPECT_EQ(folds.count, 1);
  EXPECT_EQ(folds.first_face, 2);
  EXPECT_NEAR(folds.area, 1.5 / 3.5, 1e-12);
  EXPECT_THAT(folds.is_beside, ElementsAre(0, 0, 1, 1));
}

TEST(FoldedEdges, FacesWithoutAreaTurnNowhere) {
  PolygonMesh mesh = hinged_strip(170);
  for (const int vertex : {4, 9}) mesh.positions[vertex] = mesh.positions[vertex - 1];
  const FoldedEdges folds = folded_edges(mesh);
  EXPECT_EQ(folds.count, 0);
  EXPECT_EQ(folds.area, 0.0);
}

TEST(FoldedEdges, AreTheSameByTheTopologyAtHand) {
  for (const PolygonMesh& mesh : {hinged_strip(119), hinged_strip(-121), hinged_strip(170)}) {
    const FoldedEdges folds = folded_edges(mesh), same = folded_edges(mesh, MeshTopology(mesh));
    EXPECT_EQ(same.count, folds.count);
    EXPECT_EQ(same.area, folds.area);
    EXPECT_EQ(same.first_face, folds.first_face);
    EXPECT_EQ(same.is_beside, folds.is_beside);
  }
}

TEST(FoldedEdges, AreNoneOnACube) { EXPECT_EQ(folded_edges(test::cube()).count, 0); }

}  // namespace
}  // namespace planish
