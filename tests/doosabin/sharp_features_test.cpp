#include "planish/doosabin/subdivision.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/meshes.h"

namespace planish {
namespace {

SharpFeatures features_of(const PolygonMesh& mesh, const SharpFeatureOptions& options = {}) {
  return find_sharp_features(mesh, MeshTopology(mesh), mesh.positions, options);
}

// Vertex (i, j) of a 4 x 4 grid.
std::int32_t at(int i, int j) { return j * 5 + i; }

TEST(SharpFeatures, OfAClosedMeshWithoutTagsAreNone) {
  const SharpFeatures features = features_of(test::cube());
  EXPECT_EQ(features.sharp_edge_count, 0);
  EXPECT_TRUE(features.sharp_of_edge.empty());
  EXPECT_TRUE(std::all_of(features.vertex_kinds.begin(), features.vertex_kinds.end(),
                          [](VertexKind kind) { return kind == VertexKind::Smooth; }));
}

TEST(SharpFeatures, CountTheSharpEdgesAtAVertex) {
  PolygonMesh mesh = test::flat_grid(4, 4);
  // A crease from the boundary inwards: T-junction, crease, dart.
  mesh.creases = {{at(2, 0), at(2, 1), 10}, {at(2, 2), at(2, 1), 12}};
  const SharpFeatures features = features_of(mesh);
  EXPECT_EQ(features.vertex_kinds[at(2, 0)], VertexKind::Corner);
  EXPECT_EQ(features.vertex_kinds[at(2, 1)], VertexKind::Crease);
  EXPECT_EQ(features.vertex_kinds[at(2, 2)], VertexKind::Dart);
  EXPECT_EQ(features.vertex_kinds[at(2, 3)], VertexKind::Smooth);
  EXPECT_EQ(features.vertex_kinds[at(0, 0)], VertexKind::Crease);
  EXPECT_EQ(features.sharp_edge_count, 16 + 2);
  EXPECT_EQ(features.interior_sharp_edge_count, 2);
  EXPECT_EQ(features.corner_vertices, std::vector<std::int32_t>{at(2, 0)});
}

TEST(SharpFeatures, OfLowerSharpnessOrIgnoredTagsAreNone) {
  PolygonMesh mesh = test::flat_grid(4, 4);
  mesh.creases = {{at(2, 1), at(2, 2), 3.0f}};
  EXPECT_EQ(features_of(mesh).interior_sharp_edge_count, 0);
  mesh.creases[0].sharpness = 10.0f;
  EXPECT_EQ(features_of(mesh).interior_sharp_edge_count, 1);
  EXPECT_EQ(features_of(mesh, {.use_tags = false}).interior_sharp_edge_count, 0);
}

TEST(SharpFeatures, TheLastTagOfAnEdgeHolds) {
  PolygonMesh mesh = test::flat_grid(4, 4);
  mesh.creases = {{at(2, 1), at(2, 2), 10.0f}, {at(2, 2), at(2, 1), 3.0f}};
  EXPECT_EQ(features_of(mesh).interior_sharp_edge_count, 0);
  std::ranges::reverse(mesh.creases);
  EXPECT_EQ(features_of(mesh).interior_sharp_edge_count, 1);
}

TEST(SharpFeatures, BoundaryCornersDependOnTheRule) {
  const PolygonMesh mesh = test::flat_grid(4, 4);
  EXPECT_EQ(features_of(mesh).corner_count, 0);
  const SharpFeatures features = features_of(mesh, {.boundary = BoundaryRule::EdgeAndCorner});
  EXPECT_EQ(features.corner_count, 4);
  EXPECT_EQ(features.corner_of_vertex[at(4, 4)], 3);
}

std::vector<CornerSector> sectors_of(const SharpFeatures& features) {
  std::vector<CornerSector> sectors;
  for (const auto& [key, sector] : features.corner_sectors) sectors.push_back(sector);
  std::sort(sectors.begin(), sectors.end());
  return sectors;
}

TEST(CornerSectors, FollowTheAngle) {
  PolygonMesh right_angles = test::flat_grid(4, 4);
  EXPECT_EQ(sectors_of(features_of(right_angles, {.boundary = BoundaryRule::EdgeAndCorner})),
            std::vector<CornerSector>(4, CornerSector::Convex));

  PolygonMesh straight = test::flat_grid(4, 4);
  straight.corners = {{at(2, 0), kInfiniteSharpness}};
  EXPECT_EQ(sectors_of(features_of(straight)), std::vector{CornerSector::HalfPlane});

  PolygonMesh junction = test::flat_grid(4, 4);
  junction.creases = {{at(2, 0), at(2, 1), 10}};
  EXPECT_EQ(sectors_of(features_of(junction)),
            (std::vector{CornerSector::Convex, CornerSector::Convex}));

  PolygonMesh reflex = test::l_shaped_plate(3);
  reflex.corners = {{test::vertex_at(reflex, {3, 3, 0}), kInfiniteSharpness}};
  EXPECT_EQ(sectors_of(features_of(reflex)), std::vector{CornerSector::Reflex});
}

TEST(CornerSectors, AConcavePolygonsReflexCornerCountsAsReflex) {
  // An L of one face: 270 degrees at (1, 1).
  const PolygonMesh mesh = test::make_mesh(
      {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}, {{0, 1, 2, 3, 4, 5}});
  PolygonMesh tagged = mesh;
  tagged.corners = {{3, kInfiniteSharpness}};
  EXPECT_EQ(sectors_of(features_of(tagged)), std::vector{CornerSector::Reflex});
}

}  // namespace
}  // namespace planish
