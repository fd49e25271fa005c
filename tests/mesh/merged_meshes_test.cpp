#include "planish/mesh/mesh_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mesh/test_meshes.h"
#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/statistics.h"

namespace planish {
namespace {

using testing::ElementsAre;

TEST(MergedMeshes, AreComponentsInTheirOrder) {
  PolygonMesh cube = test::cube();
  cube.creases = {{0, 1, 2.0f}};
  cube.corners = {{7}};
  cube.hole_faces = {5};
  const PolygonMesh meshes[] = {test::torus(5, 4), cube, cube};
  const MergedMeshes merged = merged_meshes(meshes);
  EXPECT_THAT(merged.first_vertices, ElementsAre(0, 20, 28, 36));
  EXPECT_THAT(merged.first_faces, ElementsAre(0, 20, 26, 32));
  EXPECT_NO_THROW(require_usable(merged.mesh, "merged"));
  EXPECT_EQ(statistics(merged.mesh).component_count, 3);
  for (int m = 0; m < 3; ++m) {
    const std::int32_t vertex = merged.first_vertices[m], face = merged.first_faces[m];
    for (std::int32_t v = 0; v < meshes[m].vertex_count(); ++v)
      EXPECT_EQ(merged.mesh.positions[vertex + v], meshes[m].positions[v]);
    for (std::int32_t f = 0; f < meshes[m].face_count(); ++f) {
      ASSERT_EQ(merged.mesh.face_size(face + f), meshes[m].face_size(f));
      for (std::int32_t k = 0; k < meshes[m].face_size(f); ++k)
        EXPECT_EQ(merged.mesh.face(face + f)[k], meshes[m].face(f)[k] + vertex);
    }
  }
  ASSERT_EQ(merged.mesh.creases.size(), 2u);
  EXPECT_EQ(merged.mesh.creases[1].v0, 28);
  EXPECT_EQ(merged.mesh.creases[1].v1, 29);
  EXPECT_EQ(merged.mesh.creases[1].sharpness, 2.0f);
  ASSERT_EQ(merged.mesh.corners.size(), 2u);
  EXPECT_EQ(merged.mesh.corners[0].vertex, 27);
  EXPECT_THAT(merged.mesh.hole_faces, ElementsAre(25, 31));
  EXPECT_TRUE(merged.mesh.uvs.empty() && merged.mesh.colors.empty() && merged.mesh.groups.empty());
}

TEST(MergedMeshes, FillUpWhatSomeDoNotHave) {
  PolygonMesh plain = test::grid(1, 1), rich = plain;
  rich.uvs = {{0, 0}, {1, 0}, {1, 1}};
  rich.face_uvs = {0, 1, 2, -1};
  rich.colors.assign(4, glm::vec4(0.5f));
  rich.groups = {{"lid", "steel"}};
  rich.face_groups = {0};
  const PolygonMesh meshes[] = {rich, plain, rich};
  const PolygonMesh mesh = merged_meshes(meshes).mesh;
  EXPECT_EQ(mesh.uvs.size(), 6u);
  EXPECT_THAT(mesh.face_uvs, ElementsAre(0, 1, 2, -1, -1, -1, -1, -1, 3, 4, 5, -1));
  ASSERT_EQ(mesh.colors.size(), 12u);
  EXPECT_EQ(mesh.colors[3], glm::vec4(0.5f));
  EXPECT_EQ(mesh.colors[4], glm::vec4(1));
  EXPECT_EQ(mesh.colors[8], glm::vec4(0.5f));
  EXPECT_THAT(mesh.face_groups, ElementsAre(0, 1, 2));
  ASSERT_EQ(mesh.groups.size(), 3u);
  EXPECT_EQ(mesh.groups[1].name, "");
  EXPECT_EQ(mesh.groups[2].name, "lid");
  EXPECT_NO_THROW(require_usable(mesh, "merged"));
}

TEST(MergedMeshes, TooManyAreRefusedByName) {
  const PolygonMesh meshes[] = {test::cube(), test::cube()};
  EXPECT_EQ(merged_meshes(meshes, 48).mesh.vertex_count(), 16);
  try {
    static_cast<void>(merged_meshes(meshes, 47));  // corners
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnusableMesh);
    EXPECT_EQ(error.element(), 1);
    EXPECT_THAT(error.what(), testing::HasSubstr("mesh 1 would make 48"));
  }
  EXPECT_EQ(merged_meshes({}).mesh.face_count(), 0);
}

}  // namespace
}  // namespace planish
