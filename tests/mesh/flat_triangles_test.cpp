#include "planish/mend/faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <glm/geometric.hpp>
#include <vector>

#include "mesh/test_meshes.h"
#include "planish/mesh/check.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/sound_topology.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

UnflattenedMesh unflattened(const PolygonMesh& mesh, bool adds_uvs = true) {
  return without_flat_triangles(mesh, usable_topology(mesh, "mesh"), adds_uvs);
}

// Two squares that share a side from (0, 0, 0) to (2, 0, 0): one lies, in two triangles, the other
// stands on it, in triangles around a point of that side and a flat one below it.
PolygonMesh squares() {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {2, 0, 2}, {0, 0, 2}, {0.5, 0, 0}};
  for (const auto& face : std::vector<std::array<std::int32_t, 3>>{
           {0, 1, 2}, {0, 2, 3}, {1, 0, 6}, {1, 6, 4}, {6, 5, 4}, {6, 0, 5}})
    mesh.add_face(face);
  return mesh;
}

double surface_area(const PolygonMesh& mesh) {
  double area = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    area += glm::length(area_vector(mesh.positions, mesh.face(f)));
  return area;
}

TEST(FlatTriangles, GiveTheirVertexToTheFaceAcross) {
  const PolygonMesh mesh = squares();
  const UnflattenedMesh made = unflattened(mesh);
  EXPECT_THAT(check(made.mesh), IsEmpty());
  EXPECT_THAT(made.flat_faces, ElementsAre(2));
  EXPECT_THAT(made.changed_faces, ElementsAre(0, 2));
  EXPECT_THAT(made.source_faces, ElementsAre(0, 0, 1, 3, 4, 5));
  EXPECT_EQ(made.mesh.positions, mesh.positions);
  EXPECT_DOUBLE_EQ(surface_area(made.mesh), 8);
  EXPECT_THAT(unflattened(made.mesh).flat_faces, IsEmpty());
}

TEST(FlatTriangles, APolygonTakesTheVertexWhole) {
  PolygonMesh mesh = squares();
  mesh.face_vertices = {0, 1, 2, 3, 1, 0, 6, 1, 6, 4, 6, 5, 4, 6, 0, 5};
  mesh.face_offsets = {0, 4, 7, 10, 13, 16};
  const UnflattenedMesh made = unflattened(mesh);
  EXPECT_THAT(check(made.mesh), IsEmpty());
  ASSERT_EQ(made.mesh.face_count(), 4);
  EXPECT_EQ(made.mesh.face_size(0), 5);
  EXPECT_THAT(made.source_faces, ElementsAre(0, 2, 3, 4));
}

TEST(FlatTriangles, AtABoundaryGo) {
  PolygonMesh mesh = squares();
  mesh.positions.erase(mesh.positions.begin() + 2, mesh.positions.begin() + 4);
  mesh.face_vertices = {1, 0, 4, 1, 4, 2, 4, 3, 2, 4, 0, 3};
  mesh.face_offsets = {0, 3, 6, 9, 12};
  const UnflattenedMesh made = unflattened(mesh);
  EXPECT_THAT(check(made.mesh), IsEmpty());
  EXPECT_THAT(made.source_faces, ElementsAre(1, 2, 3));
  EXPECT_DOUBLE_EQ(surface_area(made.mesh), 4);
}

TEST(FlatTriangles, CoordinatesOfTheVertexAreThoseOfItsPlace) {
  PolygonMesh mesh = squares();
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {7, 7}};
  // The upright square has a chart of its own.
  for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c)
    mesh.face_uvs.push_back(c < 6 ? mesh.face_vertices[c] : 4);
  const UnflattenedMesh made = unflattened(mesh);
  ASSERT_EQ(made.mesh.uvs.size(), 6u);
  EXPECT_EQ(made.mesh.uvs[5], glm::dvec2(0.25, 0));
  for (int c = 0; c < 9; ++c) {
    const std::int32_t v = made.mesh.face_vertices[c];
    EXPECT_EQ(made.mesh.face_uvs[c], v == 6 ? 5 : v) << c;
  }
  EXPECT_THAT(unflattened(mesh, false).flat_faces, IsEmpty());
  // In one chart it has some.
  for (std::int32_t& uv : mesh.face_uvs) uv = 0;
  const UnflattenedMesh same = unflattened(mesh, false);
  EXPECT_THAT(same.flat_faces, ElementsAre(2));
  EXPECT_EQ(same.mesh.face_uvs.size(), same.mesh.face_vertices.size());
}

TEST(FlatTriangles, GroupsAndHolesGoAlong) {
  PolygonMesh mesh = squares();
  mesh.groups = {{"lying", ""}, {"standing", ""}};
  mesh.face_groups = {0, 0, 1, 1, 1, 1};
  mesh.hole_faces = {4};
  const UnflattenedMesh made = unflattened(mesh);
  EXPECT_THAT(made.mesh.face_groups, ElementsAre(0, 0, 0, 1, 1, 1));
  EXPECT_THAT(made.mesh.hole_faces, ElementsAre(4));
  mesh.hole_faces = {0};
  EXPECT_THAT(unflattened(mesh).flat_faces, IsEmpty());
}

TEST(FlatTriangles, WithTaggedSidesStay) {
  PolygonMesh mesh = squares();
  mesh.creases = {{1, 0}};
  EXPECT_THAT(unflattened(mesh).flat_faces, IsEmpty());
}

// The edge that a cut would make is there: a tetrahedron of which one corner lies on a side.
TEST(FlatTriangles, WhereAnEdgeWouldBeThereTwiceStay) {
  PolygonMesh mesh = test::tetrahedron();
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 0, 0}};
  const MeshTopology topology = usable_topology(mesh, "mesh");
  EXPECT_THAT(without_flat_triangles(mesh, topology, true).flat_faces, IsEmpty());
}

// Corners in a row on one line: one round takes one of them.
TEST(FlatTriangles, InARowGoOneByOne) {
  PolygonMesh mesh = squares();
  mesh.positions.push_back({1.5, 0, 0});
  mesh.face_vertices[9] = 7;  // 1, 6, 4 becomes 7, 6, 4
  mesh.add_face(std::array{1, 7, 4});
  mesh.add_face(std::array{1, 6, 7});
  const UnflattenedMesh once = unflattened(mesh);
  ASSERT_THAT(check(once.mesh), IsEmpty());
  const UnflattenedMesh twice = unflattened(once.mesh);
  EXPECT_THAT(check(twice.mesh), IsEmpty());
  EXPECT_EQ(once.flat_faces.size() + twice.flat_faces.size(), 2u);
  EXPECT_DOUBLE_EQ(surface_area(twice.mesh), 8);
  EXPECT_THAT(unflattened(twice.mesh).flat_faces, IsEmpty());
}

TEST(FlatTriangles, AreOfNoUnit) {
  for (const double unit : {1e-200, 1e100}) {
    PolygonMesh mesh = squares();
    for (glm::dvec3& p : mesh.positions) p *= unit;
    EXPECT_THAT(unflattened(mesh).flat_faces, ElementsAre(2)) << unit;
  }
}

TEST(FlatTriangles, NeedlesAndLowTrianglesAreNone) {
  PolygonMesh mesh = squares();
  mesh.positions[6].z = 1e-4;
  EXPECT_THAT(unflattened(mesh).flat_faces, IsEmpty());
  mesh.positions[6].z = 1e-7;
  EXPECT_THAT(unflattened(mesh).flat_faces, ElementsAre(2));
  mesh.positions[6] = {1e-9, 0, 0};
  EXPECT_THAT(unflattened(mesh).flat_faces, IsEmpty());
}

}  // namespace
}  // namespace planish
