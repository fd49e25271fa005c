#include "planish/mend/faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "mesh/test_meshes.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// A unit's square whose first corner is there twice, so far apart.
PolygonMesh square_with_edge(double length) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, length, 0}};
  mesh.add_face(std::array{0, 1, 2, 3, 4});
  return mesh;
}

TEST(ShortEdges, AreThoseWithoutLength) {
  EXPECT_THAT(short_edge_targets(square_with_edge(0)), ElementsAre(0, 1, 2, 3, 0));
  EXPECT_THAT(short_edge_targets(square_with_edge(1e-6)), ElementsAre(0, 1, 2, 3, 0));
  EXPECT_THAT(short_edge_targets(square_with_edge(1e-5)), IsEmpty());
  EXPECT_THAT(short_edge_targets(test::cube()), IsEmpty());
}

TEST(ShortEdges, AreOfNoUnit) {
  for (const double unit : {1e-200, 1e100}) {
    PolygonMesh mesh = square_with_edge(1e-6);
    for (glm::dvec3& p : mesh.positions) p *= unit;
    EXPECT_THAT(short_edge_targets(mesh), ElementsAre(0, 1, 2, 3, 0)) << unit;
  }
}

// Places alone say nothing: sheets that touch are apart.
TEST(ShortEdges, VerticesWithoutAnEdgeAreNotJoined) {
  PolygonMesh mesh = square_with_edge(0);
  mesh.positions[4] = {2, 0, 0};
  mesh.positions.push_back({1, 0, 0});
  mesh.add_face(std::array{4, 2, 5});
  EXPECT_THAT(short_edge_targets(mesh), IsEmpty());
}

TEST(ShortEdges, SmallPartsOfLargeModelsStay) {
  PolygonMesh mesh = test::cube();
  const PolygonMesh part = test::cube();
  for (std::int32_t f = 0; f < part.face_count(); ++f) {
    std::vector<std::int32_t> face(part.face(f).begin(), part.face(f).end());
    for (std::int32_t& v : face) v += 8;
    mesh.add_face(face);
  }
  for (const glm::dvec3& p : part.positions) mesh.positions.push_back(1e-6 * p);
  EXPECT_THAT(short_edge_targets(mesh), IsEmpty());
  // But for those of its vertices that coincide.
  mesh.positions[9] = mesh.positions[8];
  const auto targets = short_edge_targets(mesh);
  ASSERT_EQ(targets.size(), 16u);
  for (std::int32_t v = 0; v < 16; ++v) EXPECT_EQ(targets[v], v == 9 ? 8 : v);
}

// A chain of short edges is one of some length.
TEST(ShortEdges, ManyInARowAreALine) {
  PolygonMesh mesh = square_with_edge(0);
  std::vector<std::int32_t> face{0, 1, 2, 3, 4};
  mesh.positions[4] = {0, 2e-3, 0};
  for (int i = 1; i < 2000; ++i) {
    face.push_back(mesh.vertex_count());
    mesh.positions.push_back({0, 2e-3 - 1e-6 * i, 0});
  }
  mesh.face_vertices = face;
  mesh.face_offsets = {0, static_cast<std::int32_t>(face.size())};
  EXPECT_THAT(short_edge_targets(mesh), IsEmpty());
}

TEST(ShortEdges, NothingIsSaidOfUnusableMeshes) {
  PolygonMesh mesh = square_with_edge(0);
  mesh.face_vertices[0] = 7;
  EXPECT_THAT(short_edge_targets(mesh), IsEmpty());
  mesh = square_with_edge(0);
  mesh.face_offsets = {0, 9};
  EXPECT_THAT(short_edge_targets(mesh), IsEmpty());
  mesh = square_with_edge(0);
  mesh.positions[2].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(short_edge_targets(mesh), IsEmpty());
  EXPECT_THAT(short_edge_targets({}), IsEmpty());
}

}  // namespace
}  // namespace planish
