#include "planish/features/find_features.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "features/shapes.h"
#include "planish/mesh/face_geometry.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

std::vector<KeptPlane> planes_of(const PolygonMesh& mesh) {
  const MeshTopology topology(mesh);
  std::vector<char> is_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
  for (std::int32_t e = 0; e < topology.edge_count(); ++e)
    is_sharp[e] = topology.is_boundary_edge(e) ? 1 : 0;
  for (const CreaseEdge& edge : find_features(mesh, topology).sharp_edges())
    is_sharp[topology.find_edge(edge.v0, edge.v1)] = 1;
  return find_kept_planes(mesh, topology, is_sharp);
}

// Four vertices of each of the six planes, however the faces are cut.
TEST(KeptPlanes, AreThoseBesideFillets) {
  for (const int steps : {3, 4, 6, 12})
    for (const double radius : {0.1, 0.3, 0.8}) {
      SCOPED_TRACE(::testing::Message() << steps << " steps, radius " << radius);
      const PolygonMesh box = rounded_box({1, 0.7, 0.4}, radius, steps);
      for (const PolygonMesh& mesh : {box, in_fans(box), cut_by_lot(box, 1), cut_by_lot(box, 2),
                                      turned(box), relabelled(box, 3).mesh}) {
        const std::vector<KeptPlane> planes = planes_of(mesh);
        EXPECT_EQ(planes.size(), 24U);
        for (const auto& [vertex, face] : planes) {
          const auto corners = mesh.face(face);
          EXPECT_NE(std::ranges::find(corners, vertex), corners.end());
          // No face of a fillet is as large.
          EXPECT_GT(glm::length(area_vector(mesh.positions, corners)), 0.49 * 4 * 0.7 * 0.4);
        }
      }
    }
}

// A quarter round at one edge of a box, and two half rounds: with their sharp rims.
TEST(KeptPlanes, AreNoneOfWhatIsSharpOrRound) {
  for (const auto& cases : {tuned_cases(), held_out_cases()})
    for (const FeatureCase& c : cases) {
      const std::size_t expected = c.name.starts_with("slot")          ? 8
                                   : c.name.starts_with("rounded box") ? 4
                                                                       : 0;
      EXPECT_EQ(planes_of(c.mesh).size(), expected) << c.name;
    }
}

}  // namespace
}  // namespace planish::test
