#include "planish/mend/faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "mesh/test_meshes.h"

namespace planish {
namespace {

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

TEST(CuspCorners, ClosedMeshesHaveNone) {
  EXPECT_TRUE(with_cusp_corners(test::cube()).corners.empty());
}

}  // namespace
}  // namespace planish
