#include "planish/mesh/mesh_parts.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {
namespace {

// Two triangles along an edge, numbered so that vertices 0 and 3 have no face.
PolygonMesh mesh_with_lone_vertices() {
  PolygonMesh mesh;
  mesh.positions = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {8, 8, 8}, {1, 1, 0}, {0, 1, 0}};
  mesh.add_face(std::array{1, 2, 4});
  mesh.add_face(std::array{1, 4, 5});
  mesh.creases = {{1, 4, 2}};
  mesh.corners = {{3, 1}, {5, 4}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.face_uvs = {0, 1, 2, 0, 2, 3};
  for (int v = 0; v < 6; ++v) mesh.colors.emplace_back(0.1f * static_cast<float>(v));
  mesh.attributes = {{.name = "heat", .values = {0, 1, 2, 3, 4, 5}}};
  mesh.groups = {{"one", "red"}, {"two", ""}};
  mesh.face_groups = {1, 0};
  mesh.hole_faces = {1};
  return mesh;
}

TEST(UsedVertices, AreNumberedAnewWithAllThatRidesOnThem) {
  const PolygonMesh mesh = mesh_with_lone_vertices();
  const UsedMesh used = without_unused_vertices(mesh);
  const std::vector<std::int32_t> kept{1, 2, 4, 5};
  EXPECT_EQ(used.vertices, kept);
  ASSERT_EQ(used.mesh.vertex_count(), 4);
  for (std::size_t v = 0; v < kept.size(); ++v) {
    EXPECT_EQ(used.mesh.positions[v], mesh.positions[kept[v]]);
    EXPECT_EQ(used.mesh.colors[v], mesh.colors[kept[v]]);
  }
  EXPECT_EQ(used.mesh.face_vertices, (std::vector<std::int32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(used.mesh.face_offsets, mesh.face_offsets);
  ASSERT_EQ(used.mesh.creases.size(), 1u);
  EXPECT_EQ(used.mesh.creases[0].v0, 0);
  EXPECT_EQ(used.mesh.creases[0].v1, 2);
  EXPECT_EQ(used.mesh.creases[0].sharpness, 2);
  ASSERT_EQ(used.mesh.corners.size(), 1u);  // the other's vertex is gone
  EXPECT_EQ(used.mesh.corners[0].vertex, 3);
  EXPECT_EQ(used.mesh.corners[0].sharpness, 4);
  ASSERT_EQ(used.mesh.attributes.size(), 1u);
  EXPECT_EQ(used.mesh.attributes[0].values, (std::vector<float>{1, 2, 4, 5}));
}

TEST(UsedVertices, LeaveWhatRidesOnFacesAsItIs) {
  const PolygonMesh mesh = mesh_with_lone_vertices();
  const PolygonMesh used = without_unused_vertices(mesh).mesh;
  EXPECT_EQ(used.uvs, mesh.uvs);
  EXPECT_EQ(used.face_uvs, mesh.face_uvs);
  EXPECT_EQ(used.face_groups, mesh.face_groups);
  EXPECT_EQ(used.hole_faces, mesh.hole_faces);
  ASSERT_EQ(used.groups.size(), 2u);
  EXPECT_EQ(used.groups[0].name, "one");
  EXPECT_EQ(used.groups[0].material, "red");
}

}  // namespace
}  // namespace planish
