#include "planish/fair/bending.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <Eigen/Dense>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

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
