#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <numbers>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "fair/fair_case.h"
#include "planish/fair/bending.h"
#include "planish/fair/fair_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "support/mesh_catalogue.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

// The linearised bending of a net as dense matrices, written from its formula: rows of lines
// times heights of corners. Slow on purpose.
struct BendingOracle {
  BendingOracle(const FairTopology& topology, std::span<const glm::dvec3> given,
                std::span<const glm::dvec3> normals, std::span<const glm::dvec3> offsets);

  [[nodiscard]] double energy(const Eigen::VectorXd& heights) const {
    return (values + matrix * heights).squaredNorm();
  }
  // The heights of least energy among those whose sum over every vertex's polygon is 0; corners
  // that must stay have 0.
  [[nodiscard]] Eigen::VectorXd minimiser() const;

  Eigen::MatrixXd matrix;       // 2 x corners rows, one column a corner
  Eigen::VectorXd values;       // at heights 0
  Eigen::MatrixXd constraints;  // one row a vertex: the sum over its polygon, or each corner
};

}  // namespace

using glm::dvec3;
using std::int32_t;

namespace {

constexpr double kShortestPart = 0.001;

struct NetReader {
  const FairTopology& topology;
  std::span<const dvec3> given, normals, offsets;

  int32_t vertex(int32_t index) const {
    return index < topology.corner_count
               ? topology.corner_vertices[index]
               : topology.curve_points[index - topology.corner_count].vertex;
  }
  dvec3 point(int32_t index) const { return given[vertex(index)] + offsets[index]; }
  bool moves(int32_t index) const {
    return index < topology.corner_count && topology.has_polygon(vertex(index));
  }
};

BendingOracle::BendingOracle(const FairTopology& topology, std::span<const dvec3> given,
                             std::span<const dvec3> normals, std::span<const dvec3> offsets) {
  const NetReader net{topology, given, normals, offsets};
  const int32_t n = topology.corner_count;
  matrix = Eigen::MatrixXd::Zero(2 * n, n);
  values = Eigen::VectorXd::Zero(2 * n);
  for (int32_t f = 0; f < topology.face_count; ++f) {
    const int32_t first = topology.face_offsets[f], m = topology.face_size(f);
    for (int32_t i = 0; i < m; ++i) {
      const int32_t own = first + i, next = first + (i + 1) % m, previous = first + (i + m - 1) % m;
      const int32_t after = topology.corner_ccw[own], before = topology.corner_cw[own];
      const dvec3 area =
          glm::cross(net.point(next) - net.point(after), net.point(previous) - net.point(before)) /
          4.0;
      const dvec3 normal = glm::normalize(area);
      const std::array<std::pair<int32_t, int32_t>, 2> lines{{{next, after}, {previous, before}}};
      for (int line = 0; line < 2; ++line) {
        const auto [far, near] = lines[line];
        const double far_length = glm::distance(net.point(far), net.point(own));
        const double near_length = glm::distance(net.point(near), net.point(own));
        const double whole = far_length + near_length;
        const double part = std::min(far_length, near_length) / whole;
        const double weight =
            std::sqrt(glm::length(area)) * std::clamp(part / kShortestPart - 1, 0.0, 1.0);
        const dvec3 bend = (net.point(far) - net.point(own)) / far_length -
                           (net.point(own) - net.point(near)) / near_length;
        const int32_t row = 2 * own + line;
        values[row] = weight * 2 / whole * glm::dot(normal, bend);
        const std::map<int32_t, double> factors{{far, 1 / far_length},
                                                {near, 1 / near_length},
                                                {own, -1 / far_length - 1 / near_length}};
        for (const auto& [index, factor] : factors) {
          if (!net.moves(index)) continue;
          matrix(row, index) =
              weight * 2 / whole * factor * glm::dot(normal, normals[net.vertex(index)]);
        }
      }
    }
  }

  std::vector<Eigen::VectorXd> sums;
  for (int32_t v = 0; v < topology.vertex_count; ++v) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
    for (int32_t i = topology.ring_offsets[v]; i < topology.ring_offsets[v + 1]; ++i) {
      sum[topology.ring_corners[i]] = 1;
      if (topology.has_polygon(v)) continue;
      sums.push_back(sum);  // each by itself
      sum.setZero();
    }
    if (topology.has_polygon(v)) sums.push_back(sum);
  }
  constraints.resize(static_cast<Eigen::Index>(sums.size()), n);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    constraints.row(static_cast<Eigen::Index>(i)) = sums[i].transpose();
  }
}

Eigen::VectorXd BendingOracle::minimiser() const {
  const Eigen::Index n = matrix.cols(), m = constraints.rows();
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + m, n + m);
  system.topLeftCorner(n, n) = matrix.transpose() * matrix;
  system.topRightCorner(n, m) = constraints.transpose();
  system.bottomLeftCorner(m, n) = constraints;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + m);
  right.head(n) = -matrix.transpose() * values;
  return system.completeOrthogonalDecomposition().solve(right).head(n);
}

// A net before its polish, with all that the polish is made from.
struct Net : FairCase {
  explicit Net(const PolygonMesh& polygons)
      : FairCase(polygons), offsets(FairCase::offsets(net(0).state)) {
    for (int32_t v = 0; v < topology.vertex_count; ++v) {
      normals.push_back(angle_weighted_normal(topology, given, face_normals, v, topology.ring(v)));
      // Near curves every third of them stays, every third moves half as far.
      shares.push_back(topology.is_regular[v] ? double(v % 3) / 2 : 0.0);
    }
    directions = polish_directions(topology, normals, shares);
  }
  BendingRows rows() const { return make_bending_rows(topology, given, directions, offsets); }
  BendingOracle oracle() const { return {topology, given, directions, offsets}; }
  // By corner instead of by place.
  Eigen::VectorXd heights(int32_t steps) const {
    const auto by_place = polish_heights(topology, rows(), steps);
    Eigen::VectorXd by_corner(topology.corner_count);
    for (std::size_t i = 0; i < by_place.size(); ++i) {
      by_corner[topology.ring_corners[i]] = by_place[i];
    }
    return by_corner;
  }

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
  const FairTopology& topology = c.topology;
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
  const FairTopology& topology = c.topology;
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
    Net net(mesh);
    expect_rows_of_the_formula(net);
    // Every seventh control point lies nearly on its neighbour around the vertex: lines without
    // weight.
    for (int32_t c = 0; c < net.topology.corner_count; c += 7) {
      const dvec3 other = net.offsets[net.topology.corner_ccw[c]];
      net.offsets[c] = other + 1e-4 * (net.offsets[c] - other);
    }
    expect_rows_of_the_formula(net);
  }
}

TEST(Polish, LowersTheBendingWithEveryStepAndReachesTheLeast) {
  for (const auto& [name, mesh] : small_meshes()) {
    SCOPED_TRACE(name);
    const Net net(mesh);
    const BendingOracle oracle = net.oracle();
    const double before = oracle.energy(Eigen::VectorXd::Zero(net.topology.corner_count));
    double last = before;
    for (int32_t steps = 1; steps <= 8; ++steps) {
      const double energy = oracle.energy(net.heights(steps));
      EXPECT_LT(energy, last) << steps;
      last = energy;
    }
    const double least = oracle.energy(oracle.minimiser());
    ASSERT_LT(least, 0.99 * before);
    EXPECT_LT(oracle.energy(net.heights(1000)) - least, 2e-3 * (before - least));
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

namespace planish {
namespace {

struct Case {
  explicit Case(PolygonMesh polygons)
      : mesh(std::move(polygons)),
        topology(mesh),
        features(find_sharp_features(mesh, topology, mesh.positions, {})) {
    const Placement placement = placement_of(mesh);
    for (const glm::dvec3& p : mesh.positions) given.push_back(placement.to_unit(p));
    table = make_bending_table(topology, features, given);
  }
  [[nodiscard]] LeastBending moved(double bound) const {
    return least_bending_moves(table, given, bound);
  }

  PolygonMesh mesh;
  MeshTopology topology;
  SharpFeatures features;
  std::vector<glm::dvec3> given;
  BendingTable table;
};

// Moved along the radius by noise of that standard deviation, of the diagonal.
PolygonMesh noisy_sphere(int level, double noise, std::uint32_t seed) {
  PolygonMesh mesh = test::icosphere(level);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise * std::sqrt(12.0));
  for (glm::dvec3& p : mesh.positions) p *= 1 + normal(random);
  return mesh;
}

// Rows of a closed mesh of triangles without creases from their formula, and heights along normals.
struct Oracle {
  explicit Oracle(const Case& c) : count(static_cast<Eigen::Index>(c.given.size())) {
    std::map<std::pair<int, int>, double> weights;
    std::vector<glm::dvec3> normals(c.given.size(), glm::dvec3(0.0));
    for (std::int32_t f = 0; f < c.mesh.face_count(); ++f) {
      const auto face = c.mesh.face(f);
      const glm::dvec3 centroid = (c.given[face[0]] + c.given[face[1]] + c.given[face[2]]) / 3.0;
      for (std::size_t i = 0; i < 3; ++i) {
        const int a = face[i], b = face[(i + 1) % 3], d = face[(i + 2) % 3];
        const double dual = glm::distance(centroid, (c.given[a] + c.given[b]) / 2.0);
        const double weight = dual / glm::distance(c.given[a], c.given[b]);
        weights[{a, b}] += weight;
        weights[{b, a}] += weight;
        normals[a] += glm::cross(c.given[b] - c.given[a], c.given[d] - c.given[a]);
      }
    }
    matrix = Eigen::MatrixXd::Zero(count, count);
    values = Eigen::VectorXd::Zero(count);
    Eigen::VectorXd areas = Eigen::VectorXd::Zero(count);
    for (glm::dvec3& normal : normals) normal = glm::normalize(normal);
    for (const auto& [edge, weight] : weights) {
      const auto [a, b] = edge;
      const glm::dvec3 offset = c.given[b] - c.given[a];
      areas[a] += weight * glm::dot(offset, offset) / 2;
      values[a] += weight * glm::dot(normals[a], offset);
      matrix(a, b) += weight * glm::dot(normals[a], normals[b]);
      matrix(a, a) -= weight;
    }
    for (Eigen::Index v = 0; v < count; ++v) {
      matrix.row(v) /= std::sqrt(areas[v]);
      values[v] /= std::sqrt(areas[v]);
    }
  }
  [[nodiscard]] double bending(const Eigen::VectorXd& heights) const {
    return (values + matrix * heights).squaredNorm();
  }
  // By very many short steps.
  [[nodiscard]] double least(double bound) const {
    const Eigen::MatrixXd hessian = matrix.transpose() * matrix;
    const double step = 1 / hessian.operatorNorm();
    Eigen::VectorXd heights = Eigen::VectorXd::Zero(count);
    for (int i = 0; i < 20'000; ++i) {
      heights -= step * (hessian * heights + matrix.transpose() * values);
      heights = heights.cwiseMin(bound).cwiseMax(-bound);
    }
    return bending(heights);
  }

  Eigen::Index count;
  Eigen::MatrixXd matrix;
  Eigen::VectorXd values;
};

TEST(LeastBending, ReachesTheLeastWithinItsBound) {
  const Case c(noisy_sphere(2, 0.004, 3));
  const Oracle oracle(c);
  for (const double bound : {0.001, 0.004, 0.012}) {
    const LeastBending found = c.moved(bound);
    EXPECT_NEAR(found.bending_before, oracle.bending(Eigen::VectorXd::Zero(oracle.count)),
                1e-5 * found.bending_before);
    const double least = oracle.least(bound);
    EXPECT_GE(found.bending_after, (1 - 1e-5) * least) << bound;
    EXPECT_LE(found.bending_after, 1.02 * least) << bound;
  }
}

// Areas of uneven rings are only about right, curvatures are exact.
TEST(LeastBending, IsTheIntegralOfTheSquaredCurvatureOfASphere) {
  for (const auto& [jitter, share] : {std::pair{0.0, 0.01}, std::pair{0.02, 0.08}}) {
    PolygonMesh mesh = test::jittered(test::icosphere(4), jitter, 1);
    for (glm::dvec3& p : mesh.positions) p = glm::normalize(p);
    const Case c(std::move(mesh));
    constexpr double kWhole = 8 * std::numbers::pi;
    EXPECT_NEAR(c.moved(1e-9).bending_before, kWhole, share * kWhole);
  }
}

// The corners of its boundary are smooth, and are rounded off in the plane.
TEST(LeastBending, LeavesPlanesPlane) {
  const Case c(test::flat_grid(7, 5));
  const LeastBending found = c.moved(0.01);
  for (std::size_t v = 0; v < c.given.size(); ++v) {
    EXPECT_EQ(found.moves[v].z, 0);
    if (!c.topology.is_boundary_vertex(static_cast<std::int32_t>(v))) {
      EXPECT_EQ(glm::length(found.moves[v]), 0);
    }
  }
}

TEST(LeastBending, MovesWithinTheBoundAndWhereFeaturesAllow) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const Case c(test::with_random_creases(test::random_open_mesh(seed), 0.2, seed));
    constexpr double kBound = 0.01;
    const LeastBending found = c.moved(kBound);
    EXPECT_LT(found.bending_after, found.bending_before);
    int on_curves = 0, moved_on_curves = 0;
    for (std::size_t v = 0; v < c.given.size(); ++v) {
      EXPECT_LE(glm::length(found.moves[v]), kBound * (1 + 1e-12));
      if (c.features.vertex_kinds[v] == VertexKind::Corner) {
        EXPECT_EQ(found.moves[v], glm::dvec3(0.0)) << seed << " vertex " << v;
      }
      if (c.features.vertex_kinds[v] != VertexKind::Crease) continue;
      std::vector<glm::dvec3> ends;
      for (const BendingTable::Entry& entry : c.table.row(static_cast<std::int32_t>(v)))
        if (entry.own > 0) ends.push_back(c.given[entry.vertex]);
      ASSERT_EQ(ends.size(), 2u);
      const glm::dvec3 tangent = glm::normalize(ends[0] - ends[1]);
      EXPECT_LT(std::abs(glm::dot(tangent, found.moves[v])), 1e-12);
      ++on_curves;
      moved_on_curves += glm::length(found.moves[v]) > 1e-4;
    }
    EXPECT_GT(2 * moved_on_curves, on_curves) << seed;
  }
}

TEST(LeastBending, IsTheSameForAnyNumberOfThreads) {
  const Case c(noisy_sphere(5, 0.001, 1));
  std::vector<std::vector<glm::dvec3>> moves;
  for (const std::size_t threads : {1u, 4u}) {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                            threads);
    moves.push_back(c.moved(0.001).moves);
  }
  EXPECT_EQ(moves[0], moves[1]);
}

// What moved comes nearer to the sphere, and no farther than by chance elsewhere.
TEST(LeastBending, TakesAwayNoise) {
  constexpr double kNoise = 0.002;
  const Case c(noisy_sphere(4, kNoise, 7));
  const LeastBending found = c.moved(1.25 * kNoise);
  double before = 0, after = 0;
  const glm::dvec3 centre = -placement_of(c.mesh).centre / placement_of(c.mesh).diagonal;
  const double radius = 1 / placement_of(c.mesh).diagonal;
  for (std::size_t v = 0; v < c.given.size(); ++v) {
    before += std::pow(glm::distance(c.given[v], centre) - radius, 2);
    after += std::pow(glm::distance(c.given[v] + found.moves[v], centre) - radius, 2);
  }
  EXPECT_LT(std::sqrt(after / before), 0.5);
}

TEST(MeasuredNoise, IsWhatWasAdded) {
  for (const double noise : {0.0003, 0.001, 0.003}) {
    const Case c(noisy_sphere(4, noise, 5));
    EXPECT_NEAR(measured_noise(c.table, c.given), noise, 0.12 * noise);
  }
  const Case clean(test::icosphere(4));
  EXPECT_LT(measured_noise(clean.table, clean.given), 3e-5);
  const Case few(test::icosphere(1));
  EXPECT_EQ(measured_noise(few.table, few.given), 0);
}

}  // namespace
}  // namespace planish
