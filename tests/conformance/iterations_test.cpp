// Iterations to 1e-5, 1e-6 and 1e-10 of the diagonal in double, against measured counts of an
// independent implementation. One more or less is allowed: the last error may be near a tolerance.

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "conformance/catalogue.h"
#include "planish/files/mesh_file.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"

namespace planish::test {
namespace {

using Counts = std::array<int, 3>;
constexpr double kTolerances[] = {1e-5, 1e-6, 1e-10};

struct Row {
  Weights weights;
  Solver solver;
  Counts counts;
};

void expect_counts(const PolygonMesh& mesh, double initial_error, const std::vector<Row>& rows) {
  const auto backend = make_cpu_backend();
  for (const Row& row : rows) {
    for (int t = 0; t < 3; ++t) {
      const Fit result =
          fit(mesh, *backend,
              {.weights = row.weights, .solver = row.solver, .tolerance = kTolerances[t]});
      SCOPED_TRACE("weights " + std::to_string(int(row.weights)) + " solver " +
                   std::to_string(int(row.solver)) + " tolerance " +
                   std::to_string(kTolerances[t]));
      EXPECT_TRUE(result.interpolation.converged);
      EXPECT_NEAR(result.interpolation.iterations, row.counts[t], 1);
      EXPECT_LE(result.interpolation.error.max, kTolerances[t]);
      if (initial_error > 0 && row.weights == Weights::Averaged) {
        EXPECT_NEAR(result.interpolation.history.front().max, initial_error, 0.06 * initial_error);
      }
    }
  }
}

constexpr Weights kAveraged = Weights::Averaged, kDooSabin = Weights::DooSabin;
constexpr Solver kPlain = Solver::Plain, kChebyshev = Solver::Chebyshev,
                 kGradients = Solver::ConjugateGradients;

TEST(Iterations, Torus) {
  expect_counts(torus(64, 32, 1, 0.4), 8.9e-4,
                {{kAveraged, kPlain, {1, 2, 4}},
                 {kAveraged, kChebyshev, {5, 7, 15}},
                 {kAveraged, kGradients, {1, 2, 2}},
                 {kDooSabin, kPlain, {1, 2, 4}},
                 {kDooSabin, kChebyshev, {5, 7, 15}}});
}

TEST(Iterations, Icosphere) {
  expect_counts(icosphere(4), 1.1e-3,
                {{kAveraged, kPlain, {7, 11, 29}},
                 {kAveraged, kChebyshev, {4, 6, 12}},
                 {kAveraged, kGradients, {4, 5, 12}},
                 {kDooSabin, kPlain, {5, 8, 20}},
                 {kDooSabin, kChebyshev, {3, 5, 10}}});
}

// Meshes of third parties are not part of the project; the environment says where they are.
class MeasuredMesh : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::getenv("PLANISH_TEST_DATA")) GTEST_SKIP() << "PLANISH_TEST_DATA is not set";
  }
  static PolygonMesh read(const std::string& name) {
    const std::string path = std::string(std::getenv("PLANISH_TEST_DATA")) + "/" + name;
    return read_mesh(path).mesh;
  }
};

TEST_F(MeasuredMesh, Spot) {
  expect_counts(read("spot.obj"), 5.6e-3,
                {{kAveraged, kPlain, {10, 15, 33}},
                 {kAveraged, kChebyshev, {5, 7, 13}},
                 {kAveraged, kGradients, {5, 6, 13}},
                 {kDooSabin, kPlain, {7, 10, 23}},
                 {kDooSabin, kChebyshev, {4, 5, 11}}});
}

TEST_F(MeasuredMesh, RockerArm) {
  expect_counts(read("rocker-arm.obj"), 7.8e-3,
                {{kAveraged, kPlain, {12, 16, 34}},
                 {kAveraged, kChebyshev, {5, 7, 13}},
                 {kAveraged, kGradients, {5, 7, 13}},
                 {kDooSabin, kPlain, {8, 11, 24}},
                 {kDooSabin, kChebyshev, {4, 6, 11}}});
}

TEST_F(MeasuredMesh, Suzanne) {
  expect_counts(read("suzanne.obj"), 0,
                {{kAveraged, kPlain, {18, 25, 55}},
                 {kAveraged, kChebyshev, {8, 10, 18}},
                 {kDooSabin, kPlain, {18, 25, 55}}});
}

TEST_F(MeasuredMesh, StanfordBunny) {
  expect_counts(read("stanford-bunny.obj"), 0,
                {{kAveraged, kPlain, {10, 14, 32}},
                 {kAveraged, kChebyshev, {4, 6, 13}},
                 {kDooSabin, kPlain, {7, 11, 24}},
                 {kDooSabin, kChebyshev, {4, 5, 10}}});
}

// Interpolation itself, not the solver's own word for it.
TEST(Iterations, LimitSurfacePassesThroughTheVertices) {
  const auto backend = make_cpu_backend();
  std::vector<NamedMesh> meshes = closed_meshes();
  for (NamedMesh& mesh : open_meshes()) meshes.push_back(std::move(mesh));
  for (NamedMesh& mesh : sharp_meshes()) meshes.push_back(std::move(mesh));
  for (const auto& [name, mesh] : meshes) {
    for (Solver solver : {kPlain, kChebyshev}) {
      SCOPED_TRACE(name);
      const Fit result = fit(mesh, *backend, {.solver = solver, .tolerance = 1e-10});
      EXPECT_TRUE(result.interpolation.converged);
      const std::vector<glm::dvec3> limits = limit_positions(result.cage, Weights::DooSabin, {});
      for (std::size_t v = 0; v < limits.size(); ++v) {
        EXPECT_LT(glm::distance(limits[v], mesh.positions[v]),
                  1.01e-10 * result.placement.diagonal);
      }
    }
  }
}

}  // namespace
}  // namespace planish::test
