#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "mesh/test_meshes.h"
#include "planish/mend/faults.h"
#include "planish/mesh/check.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/sound_topology.h"

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

// In any unit.
TEST(ShortEdges, AreThoseWithoutLength) {
  EXPECT_THAT(short_edge_targets(square_with_edge(0)), ElementsAre(0, 1, 2, 3, 0));
  EXPECT_THAT(short_edge_targets(square_with_edge(1e-5)), IsEmpty());
  EXPECT_THAT(short_edge_targets(test::cube()), IsEmpty());
  for (const double unit : {1.0, 1e-200, 1e100}) {
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
  // With a tagged side it stays.
  mesh = squares();
  mesh.creases = {{1, 0}};
  EXPECT_THAT(unflattened(mesh).flat_faces, IsEmpty());
}

// The edge that a cut would make is there: a tetrahedron of which one corner lies on a side.
TEST(FlatTriangles, WhereAnEdgeWouldBeThereTwiceStay) {
  PolygonMesh mesh = test::tetrahedron();
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 0, 0}};
  EXPECT_THAT(unflattened(mesh).flat_faces, IsEmpty());
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

TEST(FlatTriangles, AreOfNoUnitAndNoNeedlesNorLowTriangles) {
  for (const double unit : {1e-200, 1e100}) {
    PolygonMesh mesh = squares();
    for (glm::dvec3& p : mesh.positions) p *= unit;
    EXPECT_THAT(unflattened(mesh).flat_faces, ElementsAre(2)) << unit;
  }
  PolygonMesh mesh = squares();
  mesh.positions[6].z = 1e-4;
  EXPECT_THAT(unflattened(mesh).flat_faces, IsEmpty());
  mesh.positions[6].z = 1e-7;
  EXPECT_THAT(unflattened(mesh).flat_faces, ElementsAre(2));
  mesh.positions[6] = {1e-9, 0, 0};
  EXPECT_THAT(unflattened(mesh).flat_faces, IsEmpty());
}

// A fan of six triangles around vertex 0, slit open by `degrees` where it is not closed.
PolygonMesh slit_fan(double degrees) {
  PolygonMesh mesh;
  mesh.positions.emplace_back(0.0, 0.0, 0.0);
  for (int i = 0; i <= 6; ++i) {
    const double angle = (degrees + (360 - degrees) * i / 6) * std::numbers::pi / 180;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0.0);
  }
  for (int i = 1; i <= 6; ++i) mesh.add_face(std::array{0, i, i + 1});
  return mesh;
}

TEST(CuspCorners, AreWhereTheBoundaryTurnsByMoreThan120Degrees) {
  // At vertex 0 the boundary turns by half a turn less the slit.
  PolygonMesh tagged = with_cusp_corners(slit_fan(50));
  ASSERT_EQ(tagged.corners.size(), 1u);
  EXPECT_EQ(tagged.corners[0].vertex, 0);
  EXPECT_EQ(tagged.corners[0].sharpness, kInfiniteSharpness);
  EXPECT_TRUE(with_cusp_corners(slit_fan(70)).corners.empty());
  EXPECT_TRUE(with_cusp_corners(test::cube()).corners.empty());
}

TEST(CuspCorners, AreAlsoWhereALittleSlitsLipsBendApart) {
  // The lips stand up and hang down: there the boundary turns by a right angle only.
  const auto bent = [](double degrees) {
    PolygonMesh mesh = slit_fan(degrees);
    mesh.positions[1].z = 1;
    mesh.positions[7].z = -1;
    return std::ranges::count(with_cusp_corners(mesh).corners, 0, &CornerVertex::vertex);
  };
  EXPECT_EQ(bent(2), 1);
  EXPECT_EQ(bent(80), 0);
}

TEST(CuspCorners, KeepTagsAndTagNothingTwice) {
  PolygonMesh mesh = slit_fan(10);
  mesh.corners.push_back({0, kInfiniteSharpness});
  mesh.corners.push_back({3, 2.0f});
  EXPECT_EQ(with_cusp_corners(mesh).corners.size(), 2u);
}

// Two quads beside each other, and one above the first; a vertex has a coordinate.
PolygonMesh three_quads() {
  PolygonMesh mesh;
  for (const auto& [x, y] :
       {std::array{0, 0}, {1, 0}, {2, 0}, {0, 1}, {1, 1}, {2, 1}, {0, 2}, {1, 2}})
    mesh.positions.emplace_back(x, y, 0);
  mesh.add_face(std::array{0, 1, 4, 3});
  mesh.add_face(std::array{1, 2, 5, 4});
  mesh.add_face(std::array{3, 4, 7, 6});
  mesh.face_uvs = mesh.face_vertices;
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x, p.y);
  return mesh;
}

TEST(MirroredCharts, AreCutAlongTheirAxis) {
  PolygonMesh mesh = three_quads();
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), IsEmpty());
  EXPECT_EQ(mesh.face_uvs, mesh.face_vertices);
  // The second one as the first.
  for (const int v : {2, 5}) mesh.uvs[static_cast<std::size_t>(v)].x = 0;
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), ElementsAre(1, 4));
  EXPECT_THAT(mesh.face_uvs, ElementsAre(0, 1, 4, 3, 8, 2, 5, 9, 3, 4, 7, 6));
  EXPECT_EQ(mesh.uvs[8], mesh.uvs[1]);
  EXPECT_EQ(mesh.uvs[9], mesh.uvs[4]);
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), IsEmpty());
}

// By another set, whose indices are those of the first.
TEST(MirroredCharts, OfASetAreCutInAll) {
  PolygonMesh mesh = three_quads();
  std::vector<glm::dvec2> further = mesh.uvs;
  for (const int v : {6, 7}) further[static_cast<std::size_t>(v)].y = 0;
  EXPECT_THAT(cut_mirrored_charts(mesh, further), ElementsAre(3, 4));
  EXPECT_EQ(mesh.uvs[8], mesh.uvs[3]);
  EXPECT_EQ(mesh.uvs.size(), 10U);
}

TEST(MirroredCharts, FacesWithoutCoordinatesOrAreaCutNothing) {
  PolygonMesh mesh = three_quads();
  for (const int v : {2, 5}) mesh.uvs[static_cast<std::size_t>(v)].x = 0;
  mesh.face_uvs[5] = -1;
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), IsEmpty());
  mesh = three_quads();
  for (const int v : {2, 5}) mesh.uvs[static_cast<std::size_t>(v)].x = 1;
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), IsEmpty());
  mesh.face_uvs.clear(), mesh.uvs.clear();
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), IsEmpty());
}

}  // namespace
}  // namespace planish
