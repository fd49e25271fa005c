#include "planish/fair/fair_topology.h"

#include <gtest/gtest.h>

#include <array>
#include <glm/geometric.hpp>
#include <utility>

#include "fair/fair_case.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

dvec3 normal_at(const FairCase& c, int32_t vertex) {
  const FairTopology topology = make_fair_topology(c.mesh, c.subdivision);
  return angle_weighted_normal(topology, c.given, unit_face_normals(topology, c.given), vertex,
                               topology.ring(vertex));
}

// A prism over a polygon in the plane z = 0.
PolygonMesh prism_over(const std::vector<dvec3>& base) {
  PolygonMesh mesh;
  const auto n = static_cast<int32_t>(base.size());
  mesh.positions = base;
  for (const dvec3& p : base) mesh.positions.push_back(p + dvec3(0, 0, 1));
  std::vector<int32_t> bottom, top;
  for (int32_t i = 0; i < n; ++i) {
    const int32_t j = (i + 1) % n;
    bottom.insert(bottom.begin(), i);
    top.push_back(n + i);
    mesh.add_face(std::array{i, j, n + j, n + i});
  }
  mesh.add_face(bottom);
  mesh.add_face(top);
  return mesh;
}

TEST(VertexNormal, CountsInwardCornersByTheirWholeAngle) {
  const FairCase c(prism_over({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}));
  // 270 degrees of the top, 90 of each of the two walls of the dent.
  const dvec3 wanted = glm::normalize(dvec3(1, 1, 3));
  EXPECT_LT(glm::distance(normal_at(c, 9), wanted), 1e-12);
  // An outward corner: 90 of each.
  EXPECT_LT(glm::distance(normal_at(c, 8), glm::normalize(dvec3(1, 1, 1))), 1e-12);
}

// A face above two that together have its angle: the sum by angles is what a tilt of 1e-7 leaves.
TEST(VertexNormal, IsTheMeanOfItsFacesWhereAnglesCancel) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1e-7}};
  for (const auto& face : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}) mesh.add_face(face);
  const FairCase c(mesh);
  dvec3 sum(0.0);
  for (const auto& [a, b] : {std::pair{1, 2}, {2, 3}, {3, 1}})
    sum += glm::normalize(glm::cross(c.given[a] - c.given[0], c.given[b] - c.given[0]));
  EXPECT_LT(glm::distance(normal_at(c, 0), glm::normalize(sum)), 1e-12);
}

TEST(VertexNormal, TakesNearlyStraightCornersByTheirFace) {
  for (const double dent : {-1e-9, 0.0, 1e-9}) {
    // The middle of the front edge of the top: half a turn of it, a quarter of each wall below.
    const FairCase c(prism_over({{0, 0, 0}, {1, dent, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}));
    const dvec3 wanted = glm::normalize(dvec3(0, -1, 1));
    EXPECT_LT(glm::distance(normal_at(c, 6), wanted), 1e-8) << dent;
  }
}

TEST(VertexNormal, ChangesContinuouslyThroughAStraightCorner) {
  dvec3 before(0.0);
  for (int step = -200; step <= 200; ++step) {
    PolygonMesh mesh =
        prism_over({{0, 0, 0}, {1, 0.001 * step, 0}, {2, 0, 0}, {2, 3, 0}, {0, 3, 0}});
    mesh.positions[6].z += 0.2;  // off the plane of the top
    const dvec3 normal = normal_at(FairCase(mesh), 6);
    if (step > -200) {
      EXPECT_LT(glm::distance(normal, before), 0.01) << step;
    }
    before = normal;
  }
}

}  // namespace
}  // namespace planish::test
