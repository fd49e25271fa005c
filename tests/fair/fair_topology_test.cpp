#include "planish/fair/fair_topology.h"

#include <gtest/gtest.h>

#include <functional>

#include "conformance/catalogue.h"
#include "fair/fair_case.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/vertex_ring.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

// Every mesh with its topology.
void for_each_topology(
    const std::function<void(const FairCase& c, const FairTopology& topology)>& body) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    const FairCase c(mesh);
    body(c, make_fair_topology(c.mesh, c.subdivision));
  }
}

TEST(FairTopology, RingsAreThoseOfTheSubdivision) {
  for_each_topology([](const FairCase& c, const FairTopology& topology) {
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
  for_each_topology([](const FairCase&, const FairTopology& topology) {
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
  for_each_topology([](const FairCase& c, const FairTopology& topology) {
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
  const auto expect_same = [](const FairCase& c, const FairTopology& topology) {
    std::vector<dvec3> offsets(static_cast<std::size_t>(topology.corner_count));
    corner_offsets(topology, c.given, c.given, offsets);
    const GivenStep step(topology, c.given);
    for (int32_t corner = 0; corner < topology.corner_count; ++corner)
      EXPECT_LT(glm::distance(step.offset(corner), offsets[corner]), 1e-14);
  };
  for_each_topology(expect_same);
  const FairCase large(prism(40));  // two faces whose sums are kept
  expect_same(large, make_fair_topology(large.mesh, large.subdivision));
}

TEST(MaskedIteration, WithFullSharesIsThePlainIteration) {
  for_each_topology([](const FairCase& c, const FairTopology& topology) {
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

}  // namespace
}  // namespace planish::test
