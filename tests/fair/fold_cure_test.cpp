#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <random>

#include "fair/cure_meshes.h"
#include "fair/fair_case.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/fold_cure.h"
#include "planish/mend/repair.h"
#include "planish/mesh/check.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

struct RepairCase : FairCase {
  explicit RepairCase(const PolygonMesh& polygons)
      : FairCase(polygons), offsets(FairCase::offsets(net(0).state)), halvings(given.size(), 0) {}
  FoldCount repair() { return repair_folds(topology, given, face_normals, offsets, halvings); }
  void scale(int32_t vertex, double factor) {
    for (int32_t i = topology.ring_offsets[vertex]; i < topology.ring_offsets[vertex + 1]; ++i) {
      offsets[topology.ring_corners[i]] *= factor;
    }
  }

  std::vector<dvec3> offsets;
  std::vector<std::uint8_t> halvings;
};

TEST(FoldRepair, LeavesSoundNetsAlone) {
  RepairCase r(icosphere(2));
  const std::vector<dvec3> before = r.offsets;
  const FoldCount left = r.repair();
  EXPECT_EQ(left.edges + left.faces, 0);
  EXPECT_EQ(r.offsets, before);
  EXPECT_EQ(std::accumulate(r.halvings.begin(), r.halvings.end(), 0), 0);
}

TEST(FoldRepair, DrawsAnOverlappingPolygonIn) {
  RepairCase r(icosphere(2));
  const std::vector<dvec3> sound = r.offsets;
  r.scale(17, 6);
  const FoldCount left = r.repair();
  EXPECT_EQ(left.edges + left.faces, 0);
  EXPECT_GE(r.halvings[17], 1);
  // Only its neighbourhood, each polygon by the powers of a half that are told.
  int touched = 0;
  for (int32_t v = 0; v < r.topology.vertex_count; ++v) {
    touched += r.halvings[v] > 0;
    const double factor = std::pow(0.5, r.halvings[v]) * (v == 17 ? 6 : 1);
    for (int32_t i = r.topology.ring_offsets[v]; i < r.topology.ring_offsets[v + 1]; ++i) {
      const int32_t corner = r.topology.ring_corners[i];
      EXPECT_LT(glm::distance(r.offsets[corner], factor * sound[corner]), 1e-15);
    }
  }
  EXPECT_LE(touched, 7);
}

TEST(FoldRepair, CountsWhatShrinkingCannotCure) {
  RepairCase r(icosphere(2));
  r.scale(17, -1);  // turned over: the polygon's centre stays turned at any size
  const FoldCount left = r.repair();
  EXPECT_GT(left.edges + left.faces, 0);
  EXPECT_EQ(r.halvings[17], 3);
}

// The corner of a box, vertex 0, whose floor is cut into `needles` and whose two walls are whole:
// what a CAD program makes of a part's bottom.
PolygonMesh box_corner(int needles) {
  PolygonMesh mesh;
  mesh.positions.emplace_back(0.0, 0.0, 0.0);
  for (int i = 0; i <= needles; ++i) {
    const double angle = std::numbers::pi / 2 * i / needles;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0.0);
  }
  const int top = mesh.vertex_count();
  mesh.positions.emplace_back(0.0, 0.0, 1.0);
  // Seen from below the floor's needles run clockwise about the corner.
  for (int i = 1; i <= needles; ++i) mesh.add_face(std::array{0, i + 1, i});
  mesh.add_face(std::array{0, 1, top});
  mesh.add_face(std::array{0, top, needles + 1});
  return mesh;
}

struct Hub : FairCase {
  explicit Hub(const PolygonMesh& polygons)
      : FairCase(polygons), plane(vertex_normals(topology, given, face_normals)[0]) {}
  [[nodiscard]] glm::vec4 ellipse(const dvec3& seen_along) const {
    return hub_ellipse(topology, given, face_normals, 0, seen_along);
  }

  dvec3 plane;
};

// The least product of the polygon's sides at vertex 0 with what leads into the faces that they
// cross edges of, as a part of the side's length.
double least_crossing(const Hub& hub, std::span<const dvec3> offsets) {
  const int32_t first = hub.topology.ring_offsets[0], n = hub.topology.valence(0);
  double least = 1;
  for (int32_t i = 0; i < n; ++i) {
    const int32_t corner = hub.topology.ring_corners[first + i];
    const int32_t before = hub.topology.ring_corners[first + (i + n - 1) % n];
    const dvec3 side = offsets[corner] - offsets[before];
    const dvec3 edge = glm::normalize(hub.given[hub.topology.ring_next[first + i]] - hub.given[0]);
    for (const int32_t c : {corner, before}) {
      const dvec3 inward = glm::cross(hub.face_normals[hub.topology.corner_faces[c]], edge);
      least = std::min(least, glm::dot(side, inward) / glm::length(side));
    }
  }
  return least;
}

std::vector<dvec3> ellipse_polygon(const Hub& hub, const glm::vec4& ellipse) {
  std::vector<dvec3> offsets(std::size_t(hub.topology.state_size), dvec3(0.0));
  build_hub_ellipse(hub.topology, hub.given, 0, hub.plane, ellipse, 0.01, offsets);
  return offsets;
}

TEST(HubEllipse, ItsSidesCrossAllEdgesOfABoxesCorner) {
  for (const int needles : {5, 12, 21, 40}) {
    const Hub hub(box_corner(needles));
    const glm::vec4 ellipse = hub.ellipse(hub.plane);
    ASSERT_TRUE(is_ellipse(ellipse)) << needles;
    const std::vector<dvec3> offsets = ellipse_polygon(hub, ellipse);
    EXPECT_GT(least_crossing(hub, offsets), 0.02) << needles;
    // A circle's do not, from a few needles on.
    if (needles > 5) {
      const glm::vec4 circle(1.0F, 0.0F, 0.0F, 1.0F);
      EXPECT_LT(least_crossing(hub, ellipse_polygon(hub, circle)), 0) << needles;
    }
    // About the vertex, of the wanted size, in the plane and not turned over.
    dvec3 sum(0.0);
    double farthest = 0;
    for (int32_t i = hub.topology.ring_offsets[0]; i < hub.topology.ring_offsets[1]; ++i) {
      const dvec3& offset = offsets[hub.topology.ring_corners[i]];
      sum += offset;
      farthest = std::max(farthest, glm::length(offset));
      EXPECT_NEAR(glm::dot(offset, hub.plane), 0, 1e-15);
    }
    EXPECT_LT(glm::length(sum), 1e-15 * hub.topology.valence(0));
    EXPECT_NEAR(farthest, 0.01, 1e-8);
    const dvec3 normal = limit_normal(hub.topology, hub.topology.valence(0), [&](int32_t i) {
      return offsets[hub.topology.ring_corners[hub.topology.ring_offsets[0] + i]];
    });
    EXPECT_GT(glm::dot(normal, hub.plane), 0.99 * glm::length(normal));
  }
}

TEST(HubEllipse, TurnsWithTheMesh) {
  const Hub hub(box_corner(12));
  const glm::vec4 ellipse = hub.ellipse(hub.plane);
  const dvec3 axis = glm::normalize(dvec3(1.0, 2.0, -0.5));
  const auto turned = [&](const dvec3& p) {
    return std::cos(1.9) * p + std::sin(1.9) * glm::cross(axis, p) +
           (1 - std::cos(1.9)) * glm::dot(axis, p) * axis;
  };
  Hub other(box_corner(12));
  for (dvec3& p : other.given) p = turned(p);
  other.face_normals = unit_face_normals(other.topology, other.given);
  other.plane = turned(hub.plane);
  const std::vector<dvec3> before = ellipse_polygon(hub, ellipse);
  const std::vector<dvec3> after = ellipse_polygon(other, ellipse);
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_LT(glm::distance(after[i], turned(before[i])), 1e-15);
}

TEST(HubEllipse, IsNoneWhereNoPlaneSeesTheFaces) {
  const Hub hub(box_corner(12));
  EXPECT_FALSE(is_ellipse(hub.ellipse(-hub.plane)));
}

TEST(HubEllipse, IsChosenWhereTheCureChangedAVertexThatIsFlagged) {
  const Hub hub(box_corner(12));
  const std::size_t count = hub.given.size();
  FairDecisions decisions;
  decisions.cures.assign(count, 1);
  decisions.leans.assign(count, glm::vec2(0.0F));
  std::vector<std::uint8_t> flagged(count, 1);
  const auto chosen = choose_ellipses(hub.topology, hub.given, flagged, decisions);
  ASSERT_EQ(decisions.ellipses.size(), count);
  // All others are on the boundary.
  for (std::size_t v = 0; v < count; ++v) {
    EXPECT_EQ(chosen[v], v == 0) << v;
    EXPECT_EQ(is_ellipse(decisions.ellipses[v]), v == 0) << v;
  }
  // Once.
  EXPECT_EQ(choose_ellipses(hub.topology, hub.given, flagged, decisions)[0], 0);
  decisions.ellipses.clear();
  decisions.cures[0] = 0;
  EXPECT_EQ(choose_ellipses(hub.topology, hub.given, flagged, decisions)[0], 0);
}

// Samples of a net whose normals are turned away from a face that they belong to.
int folded_samples(const FairCase& c, std::span<const dvec3> state) {
  const FairTopology& topology = c.topology;
  const std::vector<dvec3> offsets = c.offsets({state.begin(), state.end()});
  NetSamples samples{topology, c.given, offsets};
  samples.sum_large_faces();
  int folded = 0;
  for (std::size_t e = 0; e < topology.edge_corners.size(); ++e) {
    const FairTopology::Edge edge = topology.edge(e);
    for (const int32_t face : edge.faces) {
      folded += glm::dot(samples.at_edge(edge), c.face_normals[face]) < 0;
    }
  }
  for (int32_t v = 0; v < topology.vertex_count; ++v) {
    for (int32_t i = topology.ring_offsets[v]; i < topology.ring_offsets[v + 1]; ++i) {
      const dvec3& face = c.face_normals[topology.corner_faces[topology.ring_corners[i]]];
      folded += glm::dot(samples.at_vertex(v), face) < 0;
    }
    folded += samples.least_cosine_around(v, c.face_normals) < 0;
  }
  return folded;
}

// Of large faces and rings sums stand in for their points.
TEST(NetSamples, OfLargePolygonsAreThoseOfAllPoints) {
  for (const PolygonMesh& mesh : {prism(50), bipyramid(40), prism(31)}) {
    const FairCase c(jittered(mesh, 0.05, 3));
    FairTopology topology = c.topology;
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
        result.push_back(samples.least_cosine_around(v, c.face_normals));
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
  const FairNet again = c.net(8, net.decisions);
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
    const FairNet expected = c.net(8, decisions);
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
    return c.net(0, decisions).state;
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
// of a vertex, or at corners of polygons that pass through 180 degrees.
TEST(FoldCure, MovesContinuouslyWithFrozenDecisions) {
  const struct {
    PolygonMesh mesh;
    bool is_cured;
  } cases[] = {{needle_rod(24, 6), true},
               {jittered(needle_tube(24, 4, 0.3), 0.2, 3), true},
               {jittered(needle_tube(24, 4, 0.3), 0.1, 20), true},
               {jittered(needle_rod(24, 6), 0.08, 10), true},
               {jittered(creased_rod(24, 6), 0.05, 40), true},
               {random_closed_mesh(60), false},
               {random_closed_mesh(61), false}};
  for (const auto& [mesh, is_cured] : cases) {
    MovingNet net(mesh);
    if (is_cured) {
      ASSERT_THAT(net.decisions.cures, testing::Contains(testing::Gt(0)));
    }
    for (int k = 0; k < 40; ++k) EXPECT_LT(jump_between(net, k / 40.0, (k + 1) / 40.0), 1e-4) << k;
  }
}

}  // namespace
}  // namespace planish::test
