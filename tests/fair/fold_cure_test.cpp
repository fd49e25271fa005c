#include "planish/fair/fold_cure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "fair/cure_meshes.h"
#include "fair/fair_case.h"
#include "planish/fair/fair_topology.h"
#include "planish/mend/repair.h"
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
  NetSamples samples{topology, c.given, offsets};
  samples.sum_large_faces();
  int folded = 0;
  for (std::size_t e = 0; e < topology.edge_corners.size(); ++e) {
    const FairTopology::Edge edge = topology.edge(e);
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

// Of large faces and rings sums stand in for their points.
TEST(NetSamples, OfLargePolygonsAreThoseOfAllPoints) {
  for (const PolygonMesh& mesh : {prism(50), bipyramid(40), prism(31)}) {
    const FairCase c(jittered(mesh, 0.05, 3));
    FairTopology topology = make_fair_topology(c.mesh, c.subdivision);
    const auto face_normals = unit_face_normals(topology, c.given);
    std::vector<dvec3> offsets(static_cast<std::size_t>(topology.state_size));
    for (std::size_t i = 0; i < offsets.size(); ++i) {
      const auto x = static_cast<double>(i);
      offsets[i] = 0.05 * dvec3(std::sin(x), std::cos(3 * x), std::sin(5 * x));
    }
    const auto least = [&] {
      NetSamples samples{topology, c.given, offsets};
      samples.sum_large_faces();
      std::vector<double> result;
      for (int32_t v = 0; v < topology.vertex_count; ++v)
        result.push_back(samples.least_cosine_around(v, face_normals));
      return result;
    };
    const std::vector<double> by_sums = least();
    topology.large_size = 1000;
    topology.large_faces.clear();
    const std::vector<double> by_points = least();
    for (std::size_t v = 0; v < by_sums.size(); ++v) EXPECT_NEAR(by_sums[v], by_points[v], 1e-10);
  }
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

// Spikes that are mirror images across x = 0.
PolygonMesh mirrored_spikes(unsigned seed) {
  PolygonMesh mesh = torus(16, 6, 2, 0.7);
  for (dvec3& p : mesh.positions)
    p *= 1 + 0.5 * std::sin(seed + 90.93 * std::abs(p.x) + 78.233 * p.y + 37.7 * p.z);
  return with_convex_faces(mesh).mesh;
}

// Faces that are seen equally badly, as mirror images are, decide nothing by which comes first.
TEST(FoldCure, LastBitsDecideNothing) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> bits(-1e-15, 1e-15);
  for (unsigned seed = 1; seed < 30; ++seed) {
    FairCase c(mirrored_spikes(seed));
    const FairNet net = c.net(8);
    EXPECT_GT(net.cured_vertices, 20);
    const std::vector<dvec3> given = c.given;
    for (int round = 0; round < 3; ++round) {
      for (std::size_t v = 0; v < given.size(); ++v)
        c.given[v] = given[v] + dvec3(bits(random), bits(random), bits(random));
      const std::vector<dvec3> moved = c.net(8).state;
      double farthest = 0;
      for (std::size_t i = 0; i < moved.size(); ++i)
        farthest = std::max(farthest, glm::distance(moved[i], net.state[i]));
      EXPECT_LT(farthest, 1e-9) << seed;
    }
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

// What comes before the cure is made once: each net is that of its decisions, not of the last ones.
TEST(FoldCure, RepeatsWithOtherCures) {
  const FairCase c(needle_rod(72, 30));
  FairDecisions decisions = c.net(8).decisions;
  CuredNets nets(c.mesh, c.subdivision, c.given, {.polish_steps = 8});
  const FairDecisions first = decisions;
  for (int round = 0; round < 2; ++round) {
    for (std::size_t v = static_cast<std::size_t>(round); v < decisions.cures.size(); v += 3)
      ++decisions.cures[v];
    const FairNet expected =
        fair_net(c.mesh, c.subdivision, c.given, {.polish_steps = 8, .decisions = &decisions});
    const FairNet net = nets.net(decisions);
    EXPECT_EQ(net.state, expected.state) << round;
    EXPECT_EQ(net.decisions.leans, expected.decisions.leans) << round;
    EXPECT_EQ(net.flagged_edges, expected.flagged_edges) << round;
    EXPECT_EQ(net.flagged_faces, expected.flagged_faces) << round;
  }
  EXPECT_EQ(nets.net(first).state, c.net(8).state);
}

// Control points of a mesh that bends, twists and shears, with the decisions of its rest pose.
struct MovingNet {
  explicit MovingNet(const PolygonMesh& mesh)
      : c(mesh, 1), rest(c.given), decisions(c.net(8).decisions) {}
  std::vector<dvec3> operator()(double time) {
    for (std::size_t v = 0; v < rest.size(); ++v) {
      const dvec3& p = rest[v];
      c.given[v] = p + time * dvec3(0.3 * p.z * p.z, 0.1 * p.x * p.z, 0.1 * p.z) +
                   0.05 * time * dvec3(std::sin(9 * p.y), std::sin(7 * p.z), std::cos(8 * p.x));
    }
    return fair_net(c.mesh, c.subdivision, c.given, {.polish_steps = 0, .decisions = &decisions})
        .state;
  }

  FairCase c;
  std::vector<dvec3> rest;
  FairDecisions decisions;
};

// Of the control point that moves farthest between two poses: what is left of its move when the
// time between them is halved 20 times, always where it moves farther.
double jump_between(MovingNet& net, double from, double to) {
  std::vector<dvec3> before = net(from), after = net(to);
  std::size_t point = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double moved = glm::distance(before[i], after[i]);
    if (moved > glm::distance(before[point], after[point])) point = i;
  }
  for (int halving = 0; halving < 20; ++halving) {
    std::vector<dvec3> middle = net((from + to) / 2);
    const bool is_first =
        glm::distance(before[point], middle[point]) > glm::distance(middle[point], after[point]);
    (is_first ? to : from) = (from + to) / 2;
    (is_first ? after : before) = std::move(middle);
  }
  return glm::distance(before[point], after[point]);
}

// With its decisions kept nothing that was cured jumps, not even where no direction sees all faces
// of a vertex.
TEST(FoldCure, MovesContinuouslyWithFrozenDecisions) {
  for (const PolygonMesh& mesh :
       {needle_rod(24, 6), jittered(needle_tube(24, 4, 0.3), 0.2, 3),
        jittered(needle_tube(24, 4, 0.3), 0.1, 20), jittered(needle_rod(24, 6), 0.08, 10),
        jittered(creased_rod(24, 6), 0.05, 40)}) {
    MovingNet net(mesh);
    ASSERT_THAT(net.decisions.cures, testing::Contains(testing::Gt(0)));
    for (int k = 0; k < 40; ++k) EXPECT_LT(jump_between(net, k / 40.0, (k + 1) / 40.0), 1e-4) << k;
  }
}

// At corners of polygons that pass through 180 degrees neither.
TEST(FoldCure, PolygonsMoveContinuouslyThroughStraightCorners) {
  for (const std::uint32_t seed : {60, 61}) {
    MovingNet net(random_closed_mesh(seed));
    for (int k = 0; k < 40; ++k) EXPECT_LT(jump_between(net, k / 40.0, (k + 1) / 40.0), 1e-4) << k;
  }
}

}  // namespace
}  // namespace planish::test
