#include "planish/mesh/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mesh/test_meshes.h"

namespace planish {
namespace {

using testing::ElementsAre;

TEST(Statistics, OfACubeWithAnUnusedVertex) {
  PolygonMesh mesh = test::cube();
  mesh.positions.emplace_back(9, 9, 9);
  const MeshStatistics facts = statistics(mesh);
  EXPECT_EQ(facts.vertex_count, 9);
  EXPECT_EQ(facts.unused_vertex_count, 1);
  EXPECT_EQ(facts.face_count, 6);
  EXPECT_EQ(facts.edge_count, 12);
  EXPECT_THAT(facts.face_size_counts, ElementsAre(0, 0, 0, 0, 6));
  EXPECT_THAT(facts.valence_counts, ElementsAre(0, 0, 0, 8));
  EXPECT_EQ(facts.boundary_loop_count, 0);
  EXPECT_EQ(facts.component_count, 1);
  EXPECT_EQ(facts.genus, 0);
}

TEST(Statistics, OfATorus) {
  const MeshStatistics facts = statistics(test::torus(5, 4));
  EXPECT_EQ(facts.edge_count, 40);
  EXPECT_EQ(facts.genus, 1);
  EXPECT_EQ(facts.boundary_loop_count, 0);
  EXPECT_THAT(facts.valence_counts, ElementsAre(0, 0, 0, 0, 20));
}

TEST(Statistics, OfAPlateWithAHole) {
  PolygonMesh mesh = test::grid(3, 3);
  const PolygonMesh whole = mesh;
  mesh.face_offsets = {0};
  mesh.face_vertices.clear();
  for (std::int32_t face = 0; face < whole.face_count(); ++face)
    if (face != 4) mesh.add_face(whole.face(face));
  const MeshStatistics facts = statistics(mesh);
  EXPECT_EQ(facts.boundary_loop_count, 2);
  EXPECT_EQ(facts.component_count, 1);
  EXPECT_EQ(facts.genus, 0);
  EXPECT_THAT(facts.valence_counts, ElementsAre(0, 0, 4, 8, 4));
}

TEST(Statistics, SumsOverComponents) {
  PolygonMesh mesh = test::torus(4, 4);
  const PolygonMesh parts[] = {test::torus(3, 5), test::grid(2, 2)};
  for (const PolygonMesh& part : parts) {
    const std::int32_t base = mesh.vertex_count();
    mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
    for (std::int32_t face = 0; face < part.face_count(); ++face) {
      std::vector<std::int32_t> moved(part.face(face).begin(), part.face(face).end());
      for (std::int32_t& vertex : moved) vertex += base;
      mesh.add_face(moved);
    }
  }
  const MeshStatistics facts = statistics(mesh);
  EXPECT_EQ(facts.component_count, 3);
  EXPECT_EQ(facts.genus, 2);
  EXPECT_EQ(facts.boundary_loop_count, 1);
}

}  // namespace
}  // namespace planish
