#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "make_scenes/shapes.h"
#include "planish/mesh/check.h"
#include "planish/quads/pair_triangles.h"
#include "planish/reconstruct/reconstruct.h"
#include "reconstruct/test_clouds.h"
#include "support/cut_quads.h"

namespace planish {
namespace {

TEST(PairTriangles, FindsTheSquaresOfAGrid) {
  const test::TriangleMesh grid = test::grid_mesh(6, [](int, int) { return 0.0; });
  const PolygonMesh mesh = pair_triangles(grid.positions, grid.triangles);
  EXPECT_EQ(mesh.face_count(), 36);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) EXPECT_EQ(mesh.face_size(f), 4);
  EXPECT_TRUE(check(mesh).empty());
}

TEST(PairTriangles, BeginsQuadsAtTheLostEdge) {
  const test::TriangleMesh torus = test::torus_mesh(21, 13);
  const PolygonMesh mesh = pair_triangles(torus.positions, torus.triangles);
  EXPECT_TRUE(check(mesh).empty());
  const auto sorted = [](std::int32_t a, std::int32_t b, std::int32_t c) {
    Triangle t = {a, b, c};
    std::ranges::rotate(t, std::ranges::min_element(t));
    return t;
  };
  std::vector<Triangle> expected, cut;
  for (const Triangle& t : torus.triangles) expected.push_back(sorted(t[0], t[1], t[2]));
  std::int32_t quads = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    quads += face.size() == 4;
    for (std::size_t i = 2; i < face.size(); ++i)
      cut.push_back(sorted(face[0], face[i - 1], face[i]));
  }
  EXPECT_THAT(cut, testing::UnorderedElementsAreArray(expected));
  EXPECT_GT(quads, 200);
}

// A strip of four triangles whose best pair is the middle one, which leaves both ends alone. Its
// ends hang by `drop` from a straight line.
PolygonMesh paired_strip(double drop) {
  const std::vector<glm::dvec3> positions = {
      {-0.5, 1.3 - drop, 0}, {0, 0, 0}, {0, 1.3, 0}, {1, 0, 0}, {1, 1.3, 0}, {1.5, drop, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {4, 3, 5}};
  return pair_triangles(positions, triangles);
}

TEST(PairTriangles, ExchangesAPairToJoinTwoMore) {
  const PolygonMesh mesh = paired_strip(0.2);
  ASSERT_EQ(mesh.face_count(), 2);
  EXPECT_THAT(mesh.face(0), testing::UnorderedElementsAre(0, 1, 2, 3));
  EXPECT_THAT(mesh.face(1), testing::UnorderedElementsAre(2, 3, 4, 5));
}

// The first triangle has its partner across its first edge; the third has none to exchange for.
TEST(PairTriangles, ExchangesNoPairThatGainsNone) {
  const std::vector<glm::dvec3> positions = {
      {0, 0, 0}, {1, 0, 0}, {0.5, 0.65, 0}, {0.5, -0.5, 0}, {1.4, 0.6, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}, {1, 0, 3}, {2, 1, 4}};
  const PolygonMesh mesh = pair_triangles(positions, triangles);
  ASSERT_EQ(mesh.face_count(), 2);
  EXPECT_THAT(mesh.face(0), testing::UnorderedElementsAre(0, 1, 2, 3));
  EXPECT_THAT(mesh.face(1), testing::UnorderedElementsAre(1, 2, 4));
}

TEST(PairTriangles, ExchangesNoGoodQuadForWideOnes) {
  const PolygonMesh mesh = paired_strip(-0.05);  // corners of 133 degrees
  ASSERT_EQ(mesh.face_count(), 3);
  EXPECT_THAT(mesh.face(1), testing::UnorderedElementsAre(1, 2, 3, 4));
}

TEST(PairTriangles, JoinsMostOfAnIrregularMesh) {
  // Of a simplified scan it is 80 %.
  const test::TriangleMesh torus = test::torus_mesh(80, 40);
  const SimplifiedMesh simple = simplify(torus.positions, torus.triangles, {.tolerance = 0.01});
  const PolygonMesh mesh = pair_triangles(torus.positions, simple.triangles);
  const auto joined = 2 * (static_cast<double>(simple.triangles.size()) - mesh.face_count());
  EXPECT_GT(joined / static_cast<double>(simple.triangles.size()), 0.8);
}

TEST(PairTriangles, JoinsNoQuadWithWiderCornersThanAllowed) {
  const auto faces_of_rhombus = [](double degrees, double largest) {
    const double half = degrees * std::numbers::pi / 360;
    // The edge that is lost joins the two corners of that many degrees, or the two others.
    const std::vector<glm::dvec3> positions = {{0, -std::cos(half), 0},
                                               {std::sin(half), 0, 0},
                                               {0, std::cos(half), 0},
                                               {-std::sin(half), 0, 0}};
    const int across = pair_triangles(positions, std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}},
                                      {.largest_angle = largest})
                           .face_count();
    EXPECT_EQ(pair_triangles(positions, std::vector<Triangle>{{1, 2, 3}, {1, 3, 0}},
                             {.largest_angle = largest})
                  .face_count(),
              across);
    return across;
  };
  EXPECT_EQ(faces_of_rhombus(149.9, 150), 1);
  EXPECT_EQ(faces_of_rhombus(150.1, 150), 2);
  EXPECT_EQ(faces_of_rhombus(119.9, 120), 1);
  EXPECT_EQ(faces_of_rhombus(120.1, 120), 2);
}

TEST(PairTriangles, LeavesSharpEdgesAlone) {
  const std::vector<glm::dvec3> positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1.5}};
  const std::vector<Triangle> triangles = {{0, 1, 2}, {1, 3, 2}};
  EXPECT_EQ(pair_triangles(positions, triangles).face_count(), 2);
  EXPECT_EQ(pair_triangles(positions, triangles, {.largest_turn = 80}).face_count(), 1);
}

// Triangles of meshes with whatever else meshes have; pair_triangles_test.cpp has the pairs
// themselves.

using test::cut_quads;

PairedMesh paired(const PolygonMesh& mesh, const PairOptions& options = {}) {
  return with_paired_triangles(mesh, *prepare_mesh(mesh, "mesh"), options);
}

HalvedVertices halved(const PolygonMesh& mesh, const PairOptions& options = {}) {
  return halved_vertices(mesh, *prepare_mesh(mesh, "mesh"), options);
}

PolygonMesh mesh_with(std::vector<glm::dvec3> positions,
                      std::initializer_list<std::vector<std::int32_t>> faces) {
  PolygonMesh mesh;
  mesh.positions = std::move(positions);
  for (const auto& face : faces) mesh.add_face(face);
  return mesh;
}

PolygonMesh ring(std::int32_t around, std::int32_t across) {
  return shapes::torus({.ring_count = around, .tube_count = across});
}

std::set<std::vector<std::int32_t>> faces_by_least(const PolygonMesh& mesh) {
  std::set<std::vector<std::int32_t>> faces;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    std::vector<std::int32_t> face(mesh.face(f).begin(), mesh.face(f).end());
    std::ranges::rotate(face, std::ranges::min_element(face));
    faces.insert(face);
  }
  return faces;
}

// Two triangles of a unit square, cut from vertex 0 to vertex 2.
PolygonMesh square() {
  return mesh_with({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
}

TEST(PairMesh, FindsTheQuadsThatWereCut) {
  for (const PolygonMesh& quads : {ring(32, 16), shapes::open_grid(7, 5)}) {
    const PolygonMesh triangles = cut_quads(quads);
    const PairedMesh result = paired(triangles);
    EXPECT_EQ(faces_by_least(result.mesh), faces_by_least(quads));
    EXPECT_EQ(result.pair_count, quads.face_count());
    EXPECT_EQ(result.mesh.positions, triangles.positions);
    ASSERT_EQ(std::ssize(result.source_faces), quads.face_count());
    for (std::int32_t f = 0; f < quads.face_count(); ++f) {
      const auto face = result.mesh.face(f);
      for (const std::int32_t v : triangles.face(result.source_faces[f]))
        EXPECT_NE(std::ranges::find(face, v), face.end()) << f;
    }
  }
}

TEST(PairMesh, OtherFacesStay) {
  const PolygonMesh given = mesh_with(
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, -0.5, 0}, {3, 0.5, 0}, {2, 1.5, 0}},
      {{1, 4, 5, 6, 2}, {0, 1, 2, 3}});
  const PairedMesh result = paired(cut_quads(given));
  EXPECT_EQ(result.pair_count, 1);
  EXPECT_EQ(faces_by_least(result.mesh), faces_by_least(given));
}

TEST(PairMesh, BordersStay) {
  EXPECT_EQ(paired(square()).pair_count, 1);
  PolygonMesh tagged = square(), grouped = square(), with_hole = square(), with_seam = square();
  tagged.creases = {{2, 0, 0.5f}};
  grouped.groups = {{"a", ""}, {"b", ""}};
  grouped.face_groups = {0, 1};
  with_hole.hole_faces = {1};
  with_seam.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}};
  with_seam.face_uvs = {0, 1, 2, 0, 4, 3};
  PolygonMesh with_other_seam = with_seam;
  with_other_seam.face_uvs = {4, 1, 2, 0, 2, 3};
  for (const auto& [what, mesh] : {std::pair("a tagged edge", tagged),
                                   {"groups part", grouped},
                                   {"a hole begins", with_hole},
                                   {"a seam, at one end", with_seam},
                                   {"and at the other", with_other_seam}})
    EXPECT_EQ(paired(mesh).pair_count, 0) << what;
}

TEST(PairMesh, WhatRidesOnFacesRidesOn) {
  PolygonMesh mesh = square();
  mesh.add_face(std::array{1, 4, 2});
  mesh.positions.emplace_back(9, 0, 7);
  mesh.positions.emplace_back(5, 5, 5);  // of no face
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.face_uvs = {0, 1, 2, 0, 2, 3, 1, -1, 2};
  mesh.groups = {{"a", ""}, {"b", ""}};
  mesh.face_groups = {1, 1, 0};
  mesh.hole_faces = {0, 1};
  const PairedMesh result = paired(mesh);
  ASSERT_EQ(result.pair_count, 1);
  EXPECT_THAT(result.mesh.face_groups, testing::ElementsAre(1, 0));
  EXPECT_THAT(result.mesh.hole_faces, testing::ElementsAre(0));
  EXPECT_THAT(result.source_faces, testing::ElementsAre(0, 2));
  EXPECT_EQ(result.mesh.vertex_count(), 6);
  for (std::size_t c = 0; c < 4; ++c)  // texture coordinates are those of the vertices' places
    EXPECT_EQ(result.mesh.uvs[result.mesh.face_uvs[c]],
              glm::dvec2(result.mesh.positions[result.mesh.face_vertices[c]]));
  EXPECT_TRUE(check(result.mesh).empty());
}

// The tip of a lens of two nearly flat sides, each cut from it: with both joined it would have two
// faces, which share two edges. Both quads are as good, so none is.
TEST(PairMesh, AVertexInsideKeepsThreeFaces) {
  const PolygonMesh lens =
      mesh_with({{0, 0, 1}, {1, 0, 0}, {0, 0.3, -0.6}, {-1, 0, 0}, {0, -0.3, -0.6}},
                {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {1, 4, 2}, {2, 4, 3}});
  const PairedMesh result = paired(lens);
  EXPECT_EQ(result.pair_count, 0);
  PolygonMesh uneven = lens;
  uneven.positions[2].y += 0.01;
  EXPECT_EQ(paired(uneven).pair_count, 1);
  const auto at_tip = std::ranges::count(paired(uneven).mesh.face_vertices, 0);
  EXPECT_EQ(at_tip, 3);
  EXPECT_TRUE(check(result.mesh).empty());
}

TEST(PairMesh, TellsHalvesOfQuadsFromOtherTriangles) {
  const HalvedVertices torus = halved(cut_quads(ring(32, 16)));
  EXPECT_EQ(torus.looked_at, 512);
  EXPECT_EQ(torus.telling, 512);
  EXPECT_EQ(torus.regular, 512);
  const HalvedVertices ball = halved(shapes::icosphere(3));
  EXPECT_EQ(ball.telling, 642);
  EXPECT_LT(ball.regular, 0.8 * 642);
  EXPECT_EQ(halved(cut_quads(shapes::open_grid(9, 9))).telling, 0) << "flat";
  EXPECT_EQ(halved(cut_quads(shapes::cube())).telling, 0) << "sharp";
  // Caps of a tube are cut as they may be: their rims tell nothing, its sides all.
  PolygonMesh tube;
  constexpr std::int32_t kSides = 32, kRings = 5;
  for (std::int32_t r = 0; r < kRings; ++r)
    for (std::int32_t i = 0; i < kSides; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSides, radius = r % 4 == 0 ? 0.9 : 1;
      tube.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.3 * r);
    }
  for (std::int32_t r = 0; r + 1 < kRings; ++r)
    for (std::int32_t i = 0; i < kSides; ++i) {
      const std::int32_t a = kSides * r + i, b = kSides * r + (i + 1) % kSides;
      tube.add_face(std::vector{a, b, b + kSides});
      tube.add_face(std::vector{a, b + kSides, a + kSides});
    }
  for (std::int32_t i = 1; i + 1 < kSides; ++i) {
    tube.add_face(std::vector{0, i + 1, i});
    tube.add_face(std::vector{4 * kSides, 4 * kSides + i, 4 * kSides + i + 1});
  }
  const HalvedVertices capped = halved(tube, {.largest_turn = 90});
  EXPECT_EQ(capped.telling, 3 * kSides);
  EXPECT_EQ(capped.regular, 3 * kSides);
  const HalvedVertices large = halved(cut_quads(ring(300, 200)));
  EXPECT_LT(large.looked_at, 2000);
  EXPECT_EQ(large.regular, large.telling);
}

}  // namespace
}  // namespace planish
