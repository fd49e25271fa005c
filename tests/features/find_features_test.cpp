#include "planish/features/find_features.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>
#include <utility>

#include "features/shapes.h"
#include "planish/mesh/merged_meshes.h"
#include "planish/mesh/mesh_topology.h"
#include "support/cone.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using EdgeSet = std::set<std::pair<std::int32_t, std::int32_t>>;

EdgeSet sharp_edges(const PolygonMesh& mesh) {
  EdgeSet edges;
  for (const CreaseEdge& edge : find_features(mesh).sharp_edges())
    edges.insert(std::minmax(edge.v0, edge.v1));
  return edges;
}

EdgeSet expected_edges(const FeatureCase& shape) {
  EdgeSet edges;
  for (const FeatureEdge& edge : find_features(shape.mesh).edges)
    if (shape.is_sharp(shape.mesh.positions[edge.v0], shape.mesh.positions[edge.v1]))
      edges.insert(std::minmax(edge.v0, edge.v1));
  return edges;
}

void expect_own_edges(const std::vector<FeatureCase>& cases) {
  std::size_t lost = 0;
  for (const FeatureCase& shape : cases) {
    const EdgeSet found = sharp_edges(shape.mesh), expected = expected_edges(shape);
    EXPECT_EQ(found, expected) << shape.name << ": " << found.size() << " of " << expected.size();
    lost += found != expected;
  }
  EXPECT_EQ(lost, 0u) << "of " << cases.size();
}

TEST(FindFeatures, FindsTheSharpEdgesOfShapes) { expect_own_edges(tuned_cases()); }

TEST(FindFeatures, FindsThoseOfShapesThatWereHeldOut) { expect_own_edges(held_out_cases()); }

}  // namespace
}  // namespace planish::test
