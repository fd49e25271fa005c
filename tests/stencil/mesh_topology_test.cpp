#include "planish/mesh/mesh_topology.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <opensubdiv/far/topologyLevel.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "support/descriptor_refiner.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

using test::NamedMesh;

std::vector<std::int32_t> listed(const OpenSubdiv::Vtr::ConstIndexArray& values) {
  return {values.begin(), values.end()};
}
std::vector<std::int32_t> listed(std::span<const std::int32_t> values) {
  return {values.begin(), values.end()};
}

std::vector<NamedMesh> meshes() {
  std::vector<NamedMesh> all = {{"tetrahedron", test::tetrahedron()},
                                {"torus", test::torus(24, 12, 2, 0.5)},
                                {"split edges", test::cube_with_split_edges()},
                                {"plate with a hole", test::plate_with_hole(7)},
                                {"pole of 100", test::bipyramid(100)},
                                {"open pole of 100", test::open_fan(100)},
                                {"polygon", test::single_polygon(70)},
                                {"icosphere", test::icosphere(5)}};
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    all.push_back({"closed " + std::to_string(seed),
                   test::relabelled(test::random_closed_mesh(seed), seed).mesh});
    all.push_back({"open " + std::to_string(seed),
                   test::relabelled(test::random_open_mesh(seed), seed).mesh});
  }
  for (const auto& entry : std::filesystem::directory_iterator(PLANISH_SCENES)) {
    if (entry.path().extension() != ".obj") continue;
    const std::string name = entry.path().filename().string();
    all.push_back({name, read_mesh(entry.path()).mesh});
  }
  return all;
}

TEST(MeshTopology, EqualsOpenSubdivsLevelZero) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    const MeshTopology topology(mesh);
    const auto refiner = test::descriptor_refiner(mesh, {});
    const auto& level = refiner->GetLevel(0);
    ASSERT_EQ(topology.vertex_count(), level.GetNumVertices());
    ASSERT_EQ(topology.edge_count(), level.GetNumEdges());
    ASSERT_EQ(topology.face_count(), level.GetNumFaces());
    ASSERT_EQ(topology.corner_count(), level.GetNumFaceVertices());
    for (std::int32_t f = 0; f < topology.face_count(); ++f) {
      ASSERT_EQ(listed(topology.face(f)), listed(level.GetFaceVertices(f)));
      ASSERT_EQ(listed(topology.face_edges(f)), listed(level.GetFaceEdges(f)));
    }
    for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
      const auto [v0, v1] = topology.edge_vertices(e);
      ASSERT_EQ((std::vector{v0, v1}), listed(level.GetEdgeVertices(e)));
      ASSERT_EQ(topology.is_boundary_edge(e), level.IsEdgeBoundary(e));
      ASSERT_EQ(topology.find_edge(v1, v0), e);
      const std::int32_t corner = topology.corner_of(e);
      std::vector<std::int32_t> faces{topology.face_of(corner)};
      if (!topology.is_boundary_edge(e)) faces.push_back(topology.face_of(topology.twin(corner)));
      ASSERT_EQ(faces, listed(level.GetEdgeFaces(e)));
    }
    for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
      std::vector<std::int32_t> faces, places;
      for (const std::int32_t corner : topology.corners_at(v)) {
        faces.push_back(topology.face_of(corner));
        places.push_back(topology.place_of(corner));
      }
      ASSERT_EQ(faces, listed(level.GetVertexFaces(v)));
      const auto local = level.GetVertexFaceLocalIndices(v);
      ASSERT_EQ(places, std::vector<std::int32_t>(local.begin(), local.end()));
      ASSERT_EQ(topology.is_boundary_vertex(v), level.IsVertexBoundary(v));
      ASSERT_EQ(topology.valence(v), level.GetVertexEdges(v).size());
    }
  }
}

TEST(MeshTopology, StepsAroundFacesEdgesAndVertices) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    const MeshTopology topology(mesh);
    for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
      ASSERT_EQ(topology.prev(topology.next(c)), c);
      ASSERT_EQ(topology.face_of(topology.next(c)), topology.face_of(c));
      const std::int32_t twin = topology.twin(c);
      if (twin < 0) continue;
      ASSERT_EQ(topology.twin(twin), c);
      ASSERT_EQ(topology.vertex_of(twin), topology.vertex_of(topology.next(c)));
      ASSERT_EQ(topology.edge_of(twin), topology.edge_of(c));
      ASSERT_EQ(topology.ccw(topology.cw(c)), c);
    }
    for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
      const auto corners = topology.corners_at(v);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        ASSERT_EQ(topology.vertex_of(corners[i]), v);
        const bool last = i + 1 == corners.size();
        ASSERT_EQ(topology.ccw(corners[i]), !last                            ? corners[i + 1]
                                            : topology.is_boundary_vertex(v) ? -1
                                                                             : corners[0]);
      }
    }
  }
}

TEST(MeshTopology, IsTheSameForEveryThreadCount) {
  const PolygonMesh mesh = test::relabelled(test::icosphere(6), 7).mesh;
  const MeshTopology many(mesh);
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const MeshTopology few(mesh);
  for (std::int32_t c = 0; c < many.corner_count(); ++c) {
    ASSERT_EQ(many.twin(c), few.twin(c));
    ASSERT_EQ(many.edge_of(c), few.edge_of(c));
  }
  for (std::int32_t v = 0; v < many.vertex_count(); ++v)
    ASSERT_EQ(listed(many.corners_at(v)), listed(few.corners_at(v)));
}

TEST(MeshTopology, LeavesUnusedVerticesWithoutCorners) {
  PolygonMesh mesh = test::flat_grid(2, 1);
  mesh.positions.emplace_back(9, 9, 9);
  const MeshTopology topology(mesh);
  EXPECT_EQ(topology.vertex_count(), 7);
  EXPECT_TRUE(topology.corners_at(6).empty());
  EXPECT_FALSE(topology.is_boundary_vertex(6));
  EXPECT_EQ(topology.valence(6), 0);
  EXPECT_EQ(topology.find_edge(6, 0), -1);
  EXPECT_EQ(topology.find_edge(0, 7), -1);
  EXPECT_EQ(topology.find_edge(-1, 0), -1);
  EXPECT_EQ(topology.find_edge(0, 4), -1);  // a diagonal
}

// Three faces at an edge, two of one direction, two fans at a vertex.
TEST(MeshTopology, RefusesWhatIsNoManifold) {
  for (const int valence : {3, 40}) {
    const PolygonMesh fan = test::open_fan(valence);
    const std::int32_t hub = valence, other = fan.vertex_count();
    EXPECT_TRUE(MeshTopology::if_manifold(fan));

    PolygonMesh wound = fan;
    wound.positions.emplace_back(0, 0, 1);
    wound.add_face(std::array{hub, 0, other});
    EXPECT_FALSE(MeshTopology::if_manifold(wound)) << valence;

    PolygonMesh three = fan;
    three.positions.emplace_back(0, 0, 1);
    three.positions.emplace_back(0, 0, -1);
    three.add_face(std::array{1, 0, other});
    EXPECT_TRUE(MeshTopology::if_manifold(three)) << valence;
    three.add_face(std::array{1, 0, other + 1});
    EXPECT_FALSE(MeshTopology::if_manifold(three)) << valence;

    PolygonMesh two_fans = fan;
    two_fans.positions.emplace_back(0, 0, 1);
    two_fans.positions.emplace_back(0, 1, 1);
    two_fans.add_face(std::array{hub, other, other + 1});
    EXPECT_FALSE(MeshTopology::if_manifold(two_fans)) << valence;
    EXPECT_THROW(MeshTopology{two_fans}, Error);
  }
}

}  // namespace
}  // namespace planish
