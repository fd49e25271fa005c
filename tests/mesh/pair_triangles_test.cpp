#include "planish/quads/pair_triangles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planish/mesh/check.h"
#include "planish/reconstruct/reconstruct.h"
#include "reconstruct/test_clouds.h"

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

}  // namespace
}  // namespace planish
