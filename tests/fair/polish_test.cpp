#include "planish/fair/bending.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "conformance/catalogue.h"
#include "fair/bending_oracle.h"
#include "fair/fair_case.h"
#include "planish/fair/fair_topology.h"
#include "support/delaunay_sphere.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

// A net before its polish, with all that the polish is made from.
struct Net {
  explicit Net(const PolygonMesh& mesh)
      : c(mesh), topology(make_fair_topology(c.mesh, c.subdivision)) {
    offsets = c.net(0).state;
    for (int32_t i = 0; i < topology.corner_count; ++i) {
      offsets[i] -= c.given[topology.corner_vertices[i]];
    }
    for (std::size_t s = 0; s < topology.curve_points.size(); ++s) {
      offsets[topology.corner_count + s] -= c.given[topology.curve_points[s].vertex];
    }
    const auto face_normals = unit_face_normals(topology, c.given);
    for (int32_t v = 0; v < topology.vertex_count; ++v) {
      normals.push_back(
          angle_weighted_normal(topology, c.given, face_normals, v, topology.ring(v)));
      // Near curves every third of them stays, every third moves half as far.
      shares.push_back(topology.is_regular[v] ? double(v % 3) / 2 : 0.0);
    }
    directions = polish_directions(topology, normals, shares);
  }
  BendingRows rows() const { return make_bending_rows(topology, c.given, directions, offsets); }
  BendingOracle oracle() const { return {topology, c.given, directions, offsets}; }
  // By corner instead of by place.
  Eigen::VectorXd heights(int32_t steps) const {
    const auto by_place = polish_heights(topology, rows(), steps);
    Eigen::VectorXd by_corner(topology.corner_count);
    for (std::size_t i = 0; i < by_place.size(); ++i) {
      by_corner[topology.ring_corners[i]] = by_place[i];
    }
    return by_corner;
  }

  FairCase c;
  FairTopology topology;
  std::vector<dvec3> offsets, normals, directions;
  std::vector<double> shares;
};

std::vector<NamedMesh> small_meshes() {
  return {{"icosphere", jittered(icosphere(1), 0.05, 1)},
          {"torus", jittered(torus(9, 7, 1, 0.4), 0.05, 4)},
          {"random closed", random_closed_mesh(1)},
          {"random open", random_open_mesh(2)},
          {"random creases", with_random_creases(random_open_mesh(1), 0.1, 1)},
          {"grid", jittered(flat_grid(6, 7), 0.05, 2)}};
}

TEST(Polish, HoldsTheTensorProductNearCurves) {
  const FairCase c(flat_grid(8, 8));
  const FairTopology topology = make_fair_topology(c.mesh, c.subdivision);
  const std::vector<dvec3> normals(c.given.size(), dvec3(0, 0, 1));
  for (const double share : {0.0, 0.25, 1.0}) {
    const auto directions =
        polish_directions(topology, normals, std::vector<double>(c.given.size(), share));
    for (int32_t v = 0; v < topology.vertex_count; ++v) {
      // 8 x 8 quads, 9 vertices a row.
      const int32_t edges = std::min({v % 9, v / 9, 8 - v % 9, 8 - v / 9});
      const double expected = edges == 0 ? 0.0 : edges <= 2 ? 1 - share : 1.0;
      EXPECT_EQ(directions[v], expected * normals[v]) << v;
    }
  }
}

// Fair surfaces of regular quads are the progressive ones; what bends less beside a boundary that
// cannot follow is farther from them.
TEST(Polish, LeavesRegularQuadsBesideBoundariesAlone) {
  const FairCase c(grid(12, 12, [](double x, double y) {
    return dvec3(x, y, 0.1 * std::sin(0.8 * x) * std::cos(0.7 * y));
  }));
  const FairTopology topology = make_fair_topology(c.mesh, c.subdivision);
  const auto plain = c.net(0).state, polished = c.net(8).state;
  double moved = 0;
  for (int32_t corner = 0; corner < topology.corner_count; ++corner) {
    const double distance = glm::distance(plain[corner], polished[corner]);
    if (topology.is_near_curve[topology.corner_vertices[corner]]) {
      EXPECT_EQ(distance, 0) << corner;
    }
    moved = std::max(moved, distance);
  }
  EXPECT_GT(moved, 1e-6);
}

void expect_rows_of_the_formula(const Net& net) {
  const BendingRows rows = net.rows();
  const BendingOracle oracle = net.oracle();
  EXPECT_NEAR(rows.value_square, oracle.values.squaredNorm(), 1e-4 * oracle.values.squaredNorm());
  const Eigen::VectorXd expected = oracle.matrix.transpose() * oracle.values;
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(net.topology.corner_count);
  for (int32_t c = 0; c < net.topology.corner_count; ++c) {
    gradient[c] += rows.products[c].face;
    for (const auto& [index, part] : {std::pair{net.topology.corner_ccw[c], rows.products[c].after},
                                      {net.topology.corner_cw[c], rows.products[c].before}}) {
      if (index < net.topology.corner_count) gradient[index] += part;
    }
  }
  EXPECT_LT((gradient - expected).norm(), 1e-4 * expected.norm());
}

TEST(Polish, RowsAgreeWithTheFormula) {
  for (const auto& [name, mesh] : small_meshes()) {
    SCOPED_TRACE(name);
    expect_rows_of_the_formula(Net(mesh));
  }
}

// Every seventh control point lies nearly on its neighbour around the vertex: lines without weight.
TEST(Polish, RowsLeaveOutLinesWithTooShortParts) {
  for (const auto& [name, mesh] : small_meshes()) {
    SCOPED_TRACE(name);
    Net net(mesh);
    for (int32_t c = 0; c < net.topology.corner_count; c += 7) {
      const dvec3 other = net.offsets[net.topology.corner_ccw[c]];
      net.offsets[c] = other + 1e-4 * (net.offsets[c] - other);
    }
    expect_rows_of_the_formula(net);
  }
}

TEST(Polish, ReachesTheLeastBendingInTheEnd) {
  for (const auto& [name, mesh] : small_meshes()) {
    SCOPED_TRACE(name);
    const Net net(mesh);
    const BendingOracle oracle = net.oracle();
    const double before = oracle.energy(Eigen::VectorXd::Zero(net.topology.corner_count));
    const double least = oracle.energy(oracle.minimiser());
    ASSERT_LT(least, 0.99 * before);
    EXPECT_LT(oracle.energy(net.heights(1000)) - least, 2e-3 * (before - least));
  }
}

TEST(Polish, EveryStepLowersTheBending) {
  for (const auto& [name, mesh] : small_meshes()) {
    SCOPED_TRACE(name);
    const Net net(mesh);
    const BendingOracle oracle = net.oracle();
    double last = oracle.energy(Eigen::VectorXd::Zero(net.topology.corner_count));
    for (int32_t steps = 1; steps <= 8; ++steps) {
      const double energy = oracle.energy(net.heights(steps));
      EXPECT_LT(energy, last) << steps;
      last = energy;
    }
  }
}

TEST(Polish, KeepsCentroidsAndWhatMustStay) {
  for (const auto& [name, mesh] : small_meshes()) {
    SCOPED_TRACE(name);
    const Net net(mesh);
    const Eigen::VectorXd heights = net.heights(8);
    const double tolerance = 1e-5 * heights.cwiseAbs().maxCoeff();
    EXPECT_LT((net.oracle().constraints * heights).cwiseAbs().maxCoeff(), tolerance);
    for (int32_t c = 0; c < net.topology.corner_count; ++c) {
      if (net.topology.has_polygon(net.topology.corner_vertices[c])) continue;
      EXPECT_EQ(heights[c], 0) << c;
    }
  }
}

// A vertex that may hardly move: what its lines are divided by is bounded, else a rounding of
// others moves it.
TEST(Polish, PreconditionersAreWithinFourteenMagnitudes) {
  Net net(torus(9, 7, 1, 0.4));
  net.directions[0] *= 1e-9;
  float least = HUGE_VALF, most = 0;
  for (const float diagonal : net.rows().preconditioner) {
    if (diagonal == 0) continue;  // stays where it is
    least = std::min(least, diagonal);
    most = std::max(most, diagonal);
  }
  EXPECT_NEAR(most / least, 1e14f, 1e10f);
}

TEST(Polish, TrustsNoMoveBeyondThreeTenthsOfTheDistance) {
  const Net net(jittered(icosphere(1), 0.05, 1));
  auto heights = polish_heights(net.topology, net.rows(), 8);
  for (const float factor : {1e-6f, 1e3f}) {
    SCOPED_TRACE(factor);
    auto scaled = heights;
    for (float& height : scaled) height *= factor;
    std::vector<dvec3> offsets = net.offsets;
    apply_heights(net.topology, net.directions, scaled, offsets);
    for (int32_t v = 0; v < net.topology.vertex_count; ++v) {
      double farthest = 0;
      dvec3 sum(0.0);
      for (int32_t i = net.topology.ring_offsets[v]; i < net.topology.ring_offsets[v + 1]; ++i) {
        const int32_t corner = net.topology.ring_corners[i];
        const dvec3 move = offsets[corner] - net.offsets[corner];
        farthest = std::max(farthest, glm::length(move) / glm::length(net.offsets[corner]));
        sum += offsets[corner];
        EXPECT_LT(glm::length(glm::cross(move, net.normals[v])), 1e-15);
        if (factor < 1) {
          EXPECT_NEAR(glm::dot(move, net.normals[v]), scaled[i], 1e-12);
        }
      }
      if (factor > 1) {
        EXPECT_NEAR(farthest, 0.3, 1e-9);
      }
      EXPECT_LT(glm::length(sum), 1e-15);
    }
  }
}

}  // namespace
}  // namespace planish::test
