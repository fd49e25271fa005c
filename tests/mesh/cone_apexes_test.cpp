#include "planish/mesh/cone_apexes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "planish/mesh/detect_creases.h"
#include "planish/mesh/face_areas.h"
#include "support/cone.h"

namespace planish {
namespace {

using Apexes = std::vector<std::int32_t>;

Apexes apexes_of(const PolygonMesh& mesh) {
  const MeshTopology topology(mesh);
  const std::vector<std::uint8_t> none_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
  return cone_apexes(topology, face_areas(mesh), none_sharp);
}

PolygonMesh from_inside(PolygonMesh mesh) {
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    std::reverse(mesh.face_vertices.begin() + mesh.face_offsets[f],
                 mesh.face_vertices.begin() + mesh.face_offsets[f + 1]);
  return mesh;
}

TEST(ConeApexes, AreWhereAConeEnds) {
  for (const int n : {12, 16, 32, 301})
    for (const double height : {0.75, 1.0, 1.5})
      for (const int rings : {1, 2, 5}) {
        const PolygonMesh cone = test::cone(n, height, rings);
        const Apexes tip{cone.vertex_count() - 1};
        EXPECT_EQ(apexes_of(cone), tip) << n << " sides, height " << height;
        EXPECT_EQ(apexes_of(from_inside(cone)), tip) << "a hole's end";
      }
  // Faces lean by 35 degrees where the height is tan(35 degrees) = 0.70 of the radius.
  EXPECT_EQ(apexes_of(test::cone(64, 0.72)), Apexes{64});
  EXPECT_TRUE(apexes_of(test::cone(64, 0.68)).empty());
}

TEST(ConeApexes, OfAnObliqueCone) {
  PolygonMesh cone = test::cone(32, 2);
  cone.positions.back().x = 0.6;
  EXPECT_EQ(apexes_of(cone), Apexes{32});
}

TEST(ConeApexes, PyramidsHaveNone) {
  for (const int n : {3, 4, 6, 8}) EXPECT_TRUE(apexes_of(test::cone(n, 2)).empty()) << n;
}

TEST(ConeApexes, PolesOfRoundShapesAreNone) {
  // Faces at the poles lean as those of cones do, the ones behind them twice as far.
  for (const double stretch : {1.0, 1.5, 3.0}) {
    PolygonMesh ball = test::cone(16, 1, 3);
    for (glm::dvec3& p : ball.positions) {
      const double radius = std::sqrt(p.x * p.x + p.y * p.y);
      p.z = stretch * std::cos(0.5 * std::numbers::pi * radius);
      const double wider = radius > 0 ? std::sin(0.5 * std::numbers::pi * radius) / radius : 1;
      p.x *= wider;
      p.y *= wider;
    }
    EXPECT_TRUE(apexes_of(ball).empty()) << stretch;
  }
}

TEST(ConeApexes, FacesHaveToGoAroundOnce) {
  PolygonMesh crown = test::cone(32, 1);
  for (int i = 0; i < 32; ++i) crown.positions[i].z = i % 4 < 2 ? 0.4 : -0.4;
  EXPECT_TRUE(apexes_of(crown).empty());
}

TEST(DetectCreases, TheTipOfAConeIsACorner) {
  const PolygonMesh cone = test::with_base(test::cone(24, 1.5), 24);
  const PolygonMesh found = with_detected_creases(cone);
  EXPECT_EQ(found.creases.size(), 24u) << "its rim";
  ASSERT_EQ(found.corners.size(), 1u);
  EXPECT_EQ(found.corners.front().vertex, 24);
  EXPECT_TRUE(apexes_of(cone).empty()) << "a smooth rim goes on behind the faces";
  std::vector<std::uint8_t> smooth(cone.positions.size(), 0);
  smooth[24] = 1;
  EXPECT_TRUE(with_detected_creases(cone, {.smooth_vertices = smooth}).corners.empty());
}

}  // namespace
}  // namespace planish
