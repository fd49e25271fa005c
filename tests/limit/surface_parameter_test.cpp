// Parameters of faces are OpenSubdiv's.
#include "planish/mesh/mesh_topology.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opensubdiv/bfr/parameterization.h>

#include <random>

#include "support/expect_error.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using OpenSubdiv::Bfr::Parameterization;
using ::testing::HasSubstr;

TEST(SurfaceParameter, IsThatOfOpenSubdiv) {
  for (int m = 3; m <= 30; ++m) {
    const MeshTopology topology(single_polygon(m));
    const Parameterization theirs(OpenSubdiv::Sdc::SCHEME_CATMARK, m);
    for (int i = 0; i < m; ++i) {
      double vertex[2], edge[2], centre[2];
      theirs.GetVertexCoord(i, vertex);
      theirs.GetEdgeCoord(i, 0.25, edge);
      theirs.GetCenterCoord(centre);
      const SurfaceParameter v = surface_parameter(topology, i, 0, 0);
      const SurfaceParameter e = surface_parameter(topology, i, 0.5, 0);
      const SurfaceParameter f = surface_parameter(topology, i, 1, 1);
      EXPECT_NEAR(v.u, vertex[0], 1e-15);
      EXPECT_NEAR(v.v, vertex[1], 1e-15);
      EXPECT_NEAR(e.u, edge[0], 1e-15);
      EXPECT_NEAR(e.v, edge[1], 1e-15);
      if (m != 4 && i != 0) continue;  // theirs names the centre once
      EXPECT_NEAR(f.u, centre[0], 1e-15) << m << " " << i;
      EXPECT_NEAR(f.v, centre[1], 1e-15);
    }
  }
}

TEST(SurfaceParameter, ComesBackFromCorners) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> within(0, 1);
  for (const int m : {3, 4, 5, 9, 10, 26}) {
    const MeshTopology topology(single_polygon(m));
    for (int i = 0; i < m; ++i) {
      const double u = within(random), v = within(random);
      const CornerParameter back = corner_parameter(topology, surface_parameter(topology, i, u, v));
      EXPECT_EQ(back.corner, i);
      EXPECT_NEAR(back.u, u, 1e-14);
      EXPECT_NEAR(back.v, v, 1e-14);
    }
  }
}

TEST(SurfaceParameter, PlacesOutsideAreRefused) {
  const MeshTopology quad(single_polygon(4)), triangle(single_polygon(3));
  const auto message = [](const MeshTopology& topology, const SurfaceParameter& at) {
    return message_of(ErrorCode::InvalidArgument, [&] { (void)corner_parameter(topology, at); });
  };
  EXPECT_THAT(message(quad, {1, 0, 0}), HasSubstr("the mesh has 1 faces"));
  EXPECT_THAT(message(quad, {0, 1.1, 0}), HasSubstr("face 0 at (1.1, 0): lies outside the face"));
  EXPECT_THAT(message(quad, {0, 0, std::nan("")}), HasSubstr("lies outside"));
  EXPECT_THAT(message(triangle, {0, 1.2, 1.2}), HasSubstr("lies outside"));
  EXPECT_THAT(message(triangle, {0, 0.6, 0}), HasSubstr("lies outside"));
  EXPECT_NEAR(corner_parameter(quad, {0, 1 + 1e-12, 0}).v, 0, 1e-15);
}

}  // namespace
}  // namespace planish::test
