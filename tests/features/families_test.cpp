#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "features/bodies.h"
#include "planish/features/find_features.h"

namespace planish::test {
namespace {

using VertexPairs = std::set<std::pair<std::int32_t, std::int32_t>>;

VertexPairs pairs_of(const std::vector<CreaseEdge>& edges) {
  VertexPairs pairs;
  for (const CreaseEdge& edge : edges) pairs.insert(std::minmax(edge.v0, edge.v1));
  return pairs;
}

// Of each family bodies by lot, each as it is and in other meshes. At length: features_sweep.
void expect_edges_of(const std::vector<BodyFamily>& families) {
  constexpr std::uint32_t kBodies = 6;
  constexpr int kMeshes = 4;
  for (const BodyFamily& family : families)
    for (std::uint32_t seed = 1; seed <= kBodies; ++seed) {
      Lot lot(seed);
      const Body body = family.draw(lot);
      for (int k = 0; k < kMeshes; ++k) {
        std::string what;
        const KnownMesh known = k == 0 ? known_mesh(body) : presented(body, lot, what);
        EXPECT_EQ(pairs_of(find_features(known.mesh).sharp_edges()), pairs_of(known.sharp))
            << family.name << ", seed " << seed << what;
      }
    }
}

TEST(FeatureFamilies, HaveTheirEdgesInEveryMesh) { expect_edges_of(known_families()); }

TEST(FeatureFamilies, HaveThemWhereTheyCameLater) { expect_edges_of(held_out_families()); }

}  // namespace
}  // namespace planish::test
