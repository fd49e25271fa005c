#include "planish/fair/fold_cure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "fair/cure_meshes.h"
#include "fair/fair_case.h"
#include "planish/fair/net_samples.h"
#include "planish/fair/vertex_frame.h"
#include "planish/mesh/check.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

// Samples of a net whose normals are turned away from a face that they belong to.
int folded_samples(const FairCase& c, std::span<const dvec3> state) {
  const FairTopology topology = make_fair_topology(c.mesh, c.subdivision);
  const auto face_normals = unit_face_normals(topology, c.given);
  std::vector<dvec3> offsets(state.begin(), state.end());
  for (int32_t i = 0; i < topology.corner_count; ++i) {
    offsets[i] -= c.given[topology.corner_vertices[i]];
  }
  const NetSamples samples{topology, c.given, offsets};
  int folded = 0;
  for (const FairTopology::Edge& edge : topology.edges) {
    for (const int32_t face : edge.faces) {
      folded += glm::dot(samples.at_edge(edge), face_normals[face]) < 0;
    }
  }
  for (int32_t v = 0; v < topology.vertex_count; ++v) {
    for (int32_t i = topology.ring_offsets[v]; i < topology.ring_offsets[v + 1]; ++i) {
      const dvec3& face = face_normals[topology.corner_faces[topology.ring_corners[i]]];
      folded += glm::dot(samples.at_vertex(v), face) < 0;
    }
    folded += samples.least_cosine_around(v, face_normals) < 0;
  }
  return folded;
}

TEST(FoldCure, LeavesSoundNetsAlone) {
  const FairCase c(icosphere(2));
  EXPECT_THAT(c.net(8).decisions.cures, testing::Each(0));
  EXPECT_EQ(c.net(8).cured_vertices, 0);
}

TEST(FoldCure, CuresNeedlesAndUnevenBoxes) {
  for (const PolygonMesh& mesh : {needle_rod(48, 10), uneven_box()}) {
    ASSERT_TRUE(check(mesh).empty());
    const FairCase c(mesh);
    const FairNet net = c.net(8);
    EXPECT_GT(net.cured_vertices, 0);
    EXPECT_EQ(net.flagged_edges, 0);
    EXPECT_EQ(net.flagged_faces, 0);
    EXPECT_EQ(folded_samples(c, net.state), 0);
  }
}

TEST(FoldCure, RepeatsItsDecisions) {
  const FairCase c(needle_rod(72, 30));
  const FairNet net = c.net(8);
  EXPECT_GT(*std::ranges::max_element(net.decisions.cures), 1);
  const FairNet again =
      fair_net(c.mesh, c.subdivision, c.given, {.polish_steps = 8, .decisions = &net.decisions});
  EXPECT_EQ(net.state, again.state);
  EXPECT_EQ(net.cured_vertices, again.cured_vertices);
}

// With its decisions kept a cured rod bends without a jump: halving the step halves the moves.
TEST(FoldCure, MovesContinuouslyWithFrozenDecisions) {
  FairCase c(needle_rod(24, 6), 1);
  const FairDecisions decisions = c.net(8).decisions;
  ASSERT_THAT(decisions.cures, testing::Contains(testing::Gt(0)));
  const std::vector<dvec3> rest = c.given;
  const auto frame = [&](double time) {
    for (std::size_t v = 0; v < rest.size(); ++v) {
      const dvec3& p = rest[v];
      c.given[v] = p + time * dvec3(0.3 * p.z * p.z, 0.1 * p.x * p.z, 0.1 * p.z);
    }
    return fair_net(c.mesh, c.subdivision, c.given, {.polish_steps = 8, .decisions = &decisions})
        .state;
  };
  const auto largest_step = [&](int count) {
    double largest = 0;
    std::vector<dvec3> last = frame(0);
    for (int k = 1; k <= count; ++k) {
      std::vector<dvec3> next = frame(static_cast<double>(k) / count);
      for (std::size_t i = 0; i < next.size(); ++i) {
        largest = std::max(largest, glm::distance(next[i], last[i]));
      }
      last = std::move(next);
    }
    return largest;
  };
  EXPECT_LT(largest_step(400), 0.35 * largest_step(100));
}

}  // namespace
}  // namespace planish::test
