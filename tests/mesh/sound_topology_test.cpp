#include "planish/mesh/sound_topology.h"

#include <gtest/gtest.h>

#include "mesh/test_meshes.h"

namespace planish::test {
namespace {

// Of meshes without a problem at once, not by the way that lists problems one by one.
TEST(SoundTopology, IsThatOfMeshesWithoutProblemsAlone) {
  for (const std::int32_t corners : {3, 12, 13, 40}) {
    PolygonMesh mesh = polygon(corners);
    EXPECT_TRUE(sound_topology(mesh)) << corners;
    mesh.face_vertices[2] = mesh.face_vertices[0];
    EXPECT_FALSE(sound_topology(mesh)) << corners << ", one twice";
  }
  for (const PolygonMesh& mesh : {tetrahedron(), cube(), torus(5, 4)}) {
    const auto topology = sound_topology(mesh);
    ASSERT_TRUE(topology);
    EXPECT_EQ(topology->corner_count(), std::ssize(mesh.face_vertices));
  }
}

// Two triangles and one large face around vertex 12, which that face passes twice: one fan.
TEST(SoundTopology, NoFaceNamesAVertexTwiceWhereAllElseIsSound) {
  const std::vector<std::int32_t> twice{12, 2, 5, 6, 7, 8, 1, 12, 4, 9, 10, 11, 0, 3};
  const PolygonMesh mesh = mesh_of(13, {{12, 1, 2}, twice, {12, 3, 4}});
  EXPECT_TRUE(MeshTopology::if_manifold(mesh));
  EXPECT_FALSE(sound_topology(mesh));
}

// Two faces of the same vertices with another between them around the lowest of these.
TEST(SoundTopology, NoTwoFacesHaveTheSameVertices) {
  const PolygonMesh mesh = mesh_of(6, {{4, 1, 2, 3, 0}, {4, 3, 2, 0, 1}, {4, 0, 2, 5}});
  EXPECT_TRUE(MeshTopology::if_manifold(mesh));
  EXPECT_FALSE(sound_topology(mesh));
}

}  // namespace
}  // namespace planish::test
