#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "fair/cure_meshes.h"
#include "fair/fair_case.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/fair/fair_net.h"
#include "planish/fair/fair_topology.h"
#include "planish/mesh/face_geometry.h"
#include "support/mesh_catalogue.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

void for_each_case(const std::function<void(const FairCase& c)>& body) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    body(FairCase(mesh));
  }
}

TEST(FairTopology, RingsAreThoseOfTheSubdivision) {
  for_each_case([](const FairCase& c) {
    const FairTopology& topology = c.topology;
    VertexRing ring;
    for (int32_t v = 0; v < c.mesh.vertex_count(); ++v) {
      gather_ring(c.subdivision, v, ring);
      ASSERT_EQ(topology.valence(v), int32_t(ring.faces.size()));
      for (std::size_t i = 0; i < ring.faces.size(); ++i) {
        const int32_t place = topology.ring_offsets[v] + int32_t(i);
        const int32_t corner = ring.faces[i];
        EXPECT_EQ(topology.ring_corners[place], corner);
        EXPECT_EQ(topology.corner_vertices[corner], v);
        // The vertex after a corner is the one before the corner clockwise of it.
        const int32_t clockwise = topology.corner_cw[corner];
        if (clockwise >= topology.corner_count) continue;
        EXPECT_EQ(topology.corner_ccw[clockwise], corner);
        const int32_t other =
            topology.ring_offsets[v] + int32_t((i + ring.faces.size() - 1) % ring.faces.size());
        EXPECT_EQ(topology.ring_next[place], topology.ring_previous[other]);
      }
    }
  });
}

TEST(FairTopology, EdgesHaveTheirFourCorners) {
  for_each_case([](const FairCase& c) {
    const FairTopology& topology = c.topology;
    for (std::size_t e = 0; e < topology.edge_corners.size(); ++e) {
      const FairTopology::Edge edge = topology.edge(e);
      const auto vertex = [&](int k) { return topology.corner_vertices[edge.corners[k]]; };
      EXPECT_EQ(vertex(1), vertex(2));
      EXPECT_EQ(vertex(0), vertex(3));
      EXPECT_NE(vertex(0), vertex(1));
      for (int k = 0; k < 4; ++k) {
        EXPECT_EQ(topology.corner_faces[edge.corners[k]], edge.faces[k / 2]);
      }
    }
  });
}

TEST(CornerOffsets, AreOneSubdivisionStep) {
  for_each_case([](const FairCase& c) {
    const FairTopology& topology = c.topology;
    std::vector<dvec3> points = c.given;
    for (std::size_t v = 0; v < points.size(); ++v)
      points[v] += dvec3(0.01 * double(v % 7), 0, 0.02);
    std::vector<dvec3> offsets(static_cast<std::size_t>(topology.corner_count));
    corner_offsets(topology, c.given, points, offsets);
    const auto table = step_table(c.subdivision, 1);
    const auto view = table.view();
    for (int32_t corner = 0; corner < topology.corner_count; ++corner) {
      dvec3 expected = -c.given[topology.corner_vertices[corner]];
      for (int32_t k = 0; k < view.sizes[corner]; ++k) {
        const int32_t entry = view.offsets[corner] + k;
        expected += view.weights[entry] * points[view.indices[entry]];
      }
      EXPECT_LT(glm::distance(offsets[corner], expected), 1e-14);
    }
  });
}

TEST(CornerOffsets, OfTheGivenPointsAreThereOneByOne) {
  const auto expect_same = [](const FairCase& c) {
    std::vector<dvec3> offsets(static_cast<std::size_t>(c.topology.corner_count));
    corner_offsets(c.topology, c.given, c.given, offsets);
    const GivenStep step(c.topology, c.given);
    for (int32_t corner = 0; corner < c.topology.corner_count; ++corner)
      EXPECT_LT(glm::distance(step.offset(corner), offsets[corner]), 1e-14);
  };
  for_each_case(expect_same);
  expect_same(FairCase(prism(40)));  // two faces whose sums are kept
}

TEST(MaskedIteration, WithFullSharesIsThePlainIteration) {
  for_each_case([](const FairCase& c) {
    const FairTopology& topology = c.topology;
    std::vector<dvec3> offsets(static_cast<std::size_t>(topology.corner_count));
    corner_offsets(topology, c.given, c.given, offsets);
    std::vector<double> shares(c.given.size(), 1.0);
    for (int32_t v = 0; v < topology.vertex_count; ++v) {
      if (topology.kind(v) == VertexKind::Corner) shares[v] = 0;
    }
    const auto points = masked_iteration(topology, c.given, shares, offsets);

    const auto masks = limit_masks(c.subdivision);
    const auto view = masks.view();
    std::vector<dvec3> expected = c.given;
    for (int step = 0; step < 3; ++step) {
      std::vector<dvec3> next = expected;
      for (int32_t v = 0; v < view.row_count(); ++v) {
        next[v] += c.given[v];
        for (int32_t k = view.offsets[v]; k < view.offsets[v] + view.sizes[v]; ++k) {
          next[v] -= view.weights[k] * expected[view.indices[k]];
        }
      }
      expected = next;
    }
    for (std::size_t v = 0; v < points.size(); ++v) {
      EXPECT_LT(glm::distance(points[v], expected[v]), 1e-14);
    }
  });
}

// Largest distance between a given point and the limit point that the level-1 rules give it: the
// centroid of its polygon, the middle of its curve points, or the corner's own position.
double interpolation_error(const FairCase& c, std::span<const dvec3> state) {
  using Exact = glm::vec<3, long double>;
  double worst = 0;
  VertexRing ring;
  for (int32_t v = 0; v < c.mesh.vertex_count(); ++v) {
    gather_ring(c.subdivision, v, ring);
    Exact limit(0);
    if (ring.kind == VertexKind::Corner) {
      limit = Exact(state[ring.corner_point]);
    } else if (ring.kind == VertexKind::Crease) {
      for (const int32_t curve : {ring.sectors[0].curve0, ring.sectors[0].curve1}) {
        limit += Exact(state[curve]) / 2.0L;
      }
    } else {
      for (const int32_t face : ring.faces) limit += Exact(state[face]);
      limit /= static_cast<long double>(ring.faces.size());
    }
    worst = std::max(worst, double(glm::distance(limit, Exact(c.given[v]))));
  }
  return worst;
}

TEST(FairNet, PassesThroughEveryGivenPoint) {
  for (const auto& [name, mesh] : fair_meshes()) {
    SCOPED_TRACE(name);
    const FairCase c(mesh);
    for (const int32_t steps : {0, 8}) {
      const FairNet net = c.net(steps);
      ASSERT_EQ(net.state.size(), std::size_t(c.subdivision.state_size()));
      EXPECT_LT(interpolation_error(c, net.state), 1e-15);
      std::vector<dvec3> rounded = net.state;
      for (dvec3& p : rounded) p = dvec3(glm::vec3(p));
      EXPECT_LT(interpolation_error(c, rounded), 4e-8);
    }
  }
}

// Of level 1, whose rules are uniform: the limit of a dart is level with the points beside it.
TEST(FairNet, DartsHaveTheirCurvePointMidway) {
  int darts = 0, cured = 0;
  for (const auto& [name, mesh] : cure_meshes()) {
    SCOPED_TRACE(name);
    const FairCase c(mesh);
    const FairTopology& topology = c.topology;
    const FairNet net = c.net(8);
    for (std::size_t s = 0; s < topology.curve_points.size(); ++s) {
      const FairTopology::CurvePoint& place = topology.curve_points[s];
      if (topology.kind(place.vertex) != VertexKind::Dart) continue;
      ++darts;
      cured += net.decisions.cures[place.vertex] > 0;
      const dvec3 middle = (net.state[place.corner_after] + net.state[place.corner_before]) / 2.0;
      const auto at = static_cast<std::size_t>(topology.corner_count) + s;
      EXPECT_LT(glm::distance(net.state[at], middle), 1e-15);
    }
  }
  EXPECT_GT(darts, cured);
  EXPECT_GT(cured, 0);
}

bool is_beside(const FairCase& c, int32_t corner, const dvec3& normal) {
  const dvec3 own = area_vector(c.given, c.mesh.face(c.split.topology().face_of(corner)));
  return glm::dot(own, normal) > 0.5 * glm::length(own);
}

// Inside the surface, at boundaries and at creases that lead from a plane to a round.
TEST(FairNet, KeepsPlanesUpToTheirBorders) {
  for (const PolygonMesh& mesh :
       {rounded_box({1, 0.7, 0.4}, 0.3, 4), plane_and_quarter_round(), slot(6)}) {
    const FairCase c(mesh);
    const std::vector<KeptPlane> planes = kept_planes(c.mesh, c.subdivision);
    EXPECT_GE(planes.size(), 4U);
    const auto farthest = [&](const FairNet& net) {
      double most = 0;
      for (const auto& [vertex, face] : planes) {
        const dvec3 normal = glm::normalize(area_vector(c.given, c.mesh.face(face)));
        for (const int32_t corner : c.split.topology().corners_at(vertex))
          if (is_beside(c, corner, normal))
            most = std::max(most, std::abs(glm::dot(normal, net.state[corner] - c.given[vertex])));
      }
      return most;
    };
    const FairNet net =
        fair_net(c.mesh, c.subdivision, c.given, {.polish_steps = 8, .planes = planes});
    EXPECT_LT(interpolation_error(c, net.state), 1e-15);
    EXPECT_LT(farthest(net), 1e-15);
    EXPECT_GT(farthest(c.net(8)), 1e-3);
    EXPECT_EQ(net.decisions.planes, planes);
    EXPECT_EQ(c.net(8, net.decisions).state, net.state);
    FairDecisions others = net.decisions;
    others.planes.back().face = c.mesh.face_count();
    EXPECT_THROW((void)c.net(8, others), Error);
  }
}

TEST(FairNet, TurnsMovesAndScalesWithTheMesh) {
  const dvec3 axis = glm::normalize(dvec3(1, 2, -0.5));
  const auto map = [&](const dvec3& p) {  // a turn by 1 radian, a scaling by 3 and a shift
    const dvec3 turned = p * std::cos(1.0) + glm::cross(axis, p) * std::sin(1.0) +
                         axis * glm::dot(axis, p) * (1 - std::cos(1.0));
    return 3.0 * turned + dvec3(0.3, -0.2, 0.5);
  };
  for (const auto& [name, mesh] : fair_meshes()) {
    SCOPED_TRACE(name);
    const FairCase c(mesh);
    std::vector<dvec3> mapped = c.given;
    for (dvec3& p : mapped) p = map(p);
    const FairNet before = c.net(8);
    const FairNet after = fair_net(c.mesh, c.subdivision, mapped, {.polish_steps = 8});
    double worst = 0;
    for (std::size_t i = 0; i < before.state.size(); ++i) {
      worst = std::max(worst, glm::distance(map(before.state[i]), after.state[i]));
    }
    EXPECT_LT(worst, 1e-6);
    EXPECT_EQ(before.flagged_edges, after.flagged_edges);
  }
}

TEST(FairNet, IsTheSameForEveryThreadCount) {
  const FairCase c(with_random_creases(random_open_mesh(2), 0.1, 3));
  const FairCase large(delaunay_sphere(3000, 5));
  for (const FairCase* one : {&c, &large}) {
    const FairNet parallel = one->net(8);
    const oneapi::tbb::global_control single(oneapi::tbb::global_control::max_allowed_parallelism,
                                             1);
    const FairNet serial = one->net(8);
    EXPECT_TRUE(std::equal(parallel.state.begin(), parallel.state.end(), serial.state.begin(),
                           serial.state.end()));
  }
}

double rms_torus_distance(const FairCase& c, const LimitSamples& samples) {
  const Placement placement = placement_of(c.mesh);
  double sum = 0;
  for (const dvec3& p : samples.positions) {
    const dvec3 q = placement.to_model(p);
    const double from_circle = std::hypot(std::hypot(q.x, q.y) - 1.0, q.z) - 0.4;
    sum += from_circle * from_circle;
  }
  return std::sqrt(sum / double(samples.positions.size())) / placement.diagonal;
}

// On narrow quads rows that bend in their tangent planes move their points far out of narrow
// wedges, all of them together: no reason to leave the tensor product.
TEST(FairNet, KeepsTheAccuracyOfTensorProductsOnRegularToruses) {
  for (const auto& [mesh, most] :
       {std::pair(torus(24, 12, 1, 0.4), 3.8e-5), std::pair(torus(12, 48, 1, 0.4), 7e-5)}) {
    const FairCase c(mesh, 3);
    EXPECT_LT(rms_torus_distance(c, limit_samples(c, c.net(0).state, 3)), most);
  }
}

// The polygon of every vertex as its own mesh numbers it must follow it to its new number.
TEST(FairNet, FollowsTheNumberingOfTheMesh) {
  for (const auto& [name, mesh] : fair_meshes()) {
    SCOPED_TRACE(name);
    const Relabelled other = relabelled(mesh, 4);
    const FairCase before(mesh), after(other.mesh);
    const FairNet net_before = before.net(8), net_after = after.net(8);
    VertexRing ring_before, ring_after;
    double worst = 0;
    for (int32_t v = 0; v < mesh.vertex_count(); ++v) {
      gather_ring(before.subdivision, v, ring_before);
      gather_ring(after.subdivision, other.new_index[v], ring_after);
      for (const int32_t face : ring_before.faces) {
        double nearest = HUGE_VAL;
        for (const int32_t candidate : ring_after.faces) {
          nearest =
              std::min(nearest, glm::distance(net_before.state[face], net_after.state[candidate]));
        }
        worst = std::max(worst, nearest);
      }
    }
    EXPECT_LT(worst, 1e-5);
  }
}

TEST(FairNet, DoesNotFoldRandomSpheres) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const FairCase c(delaunay_sphere(600, seed), 3);
    for (const int32_t steps : {0, 8}) {
      const LimitSamples samples = limit_samples(c, c.net(steps).state, 3);
      const Placement placement = placement_of(c.mesh);
      std::int64_t folded = 0;
      for (std::size_t i = 0; i < samples.positions.size(); ++i) {
        // The outward direction of the sphere.
        const dvec3 out = placement.to_model(samples.positions[i]);
        folded += glm::dot(out, dvec3(samples.normals[i])) <= 0;
      }
      EXPECT_EQ(folded, 0) << "seed " << seed << ", steps " << steps;
    }
  }
}

TEST(FairNet, RefusesStepsOutOfRange) {
  const FairCase c(cube());
  EXPECT_THROW(static_cast<void>(c.net(-1)), Error);
  EXPECT_THROW(static_cast<void>(c.net(1001)), Error);
}

TEST(FairNet, IsFiniteOnDegenerateInput) {
  FairCase c(icosphere(1));
  c.given[3] = c.given[c.mesh.face(0)[0]];                // coincident
  for (int i = 10; i < 20; ++i) c.given[i] = dvec3(0.0);  // many at once
  for (const int32_t steps : {0, 8}) {
    for (const dvec3& p : c.net(steps).state) {
      EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    }
  }
}

TEST(FairNet, RepeatsItsDecisions) {
  for (const auto& [name, mesh] : fair_meshes()) {
    SCOPED_TRACE(name);
    const FairCase c(mesh);
    const FairNet net = c.net(8);
    const FairNet again = c.net(8, net.decisions);
    EXPECT_EQ(net.state, again.state);
    EXPECT_EQ(net.flagged_edges, again.flagged_edges);
    EXPECT_EQ(net.shrunk_vertices, again.shrunk_vertices);
  }
}

// A sphere that is bent and stretched through 200 frames, its decisions those of the first.
TEST(FairNet, MovesContinuouslyWithFrozenDecisions) {
  FairCase c(delaunay_sphere(300, 2), 2);
  const FairDecisions decisions = c.net(8).decisions;
  const std::vector<dvec3> rest = c.given;
  const auto frame = [&](double time) {
    for (std::size_t v = 0; v < rest.size(); ++v) {
      const dvec3& p = rest[v];
      c.given[v] = p + time * dvec3(0.4 * p.y * p.z, 0.3 * std::sin(4 * p.x), 0.5 * p.z);
    }
    return c.net(8, decisions).state;
  };
  // A jump would not shrink with the step.
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
  EXPECT_LT(largest_step(200), 0.35 * largest_step(50));
}

}  // namespace
}  // namespace planish::test
