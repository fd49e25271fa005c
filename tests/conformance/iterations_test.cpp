#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/doosabin/limit_masks.h"
#include "planish/files/mesh_file.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/mesh_catalogue.h"

namespace planish::test {
namespace {

// Eigenvalues of the limit-mask matrix by dense linear algebra.

using std::int32_t;

constexpr double kEigenvalueRounding = 1e-9;  // non-symmetric matrices up to 400 x 400

// Smallest eigenvalue of one polygon's circulant, derived: averaged 1/2 + cos(2 pi k / m) / 4 is
// smallest for the k nearest to m / 2; of 1978 1/2 in a triangle, which has k = 0 and +-1 only, and
// 1/4 from four sides on.
double closed_form_bound(const PolygonMesh& mesh, Weights weights) {
  double bound = 1;
  for (int32_t f = 0; f < mesh.face_count(); ++f) {
    const int32_t m = mesh.face_size(f);
    const double averaged = m % 2 == 0 ? 0.25 : 0.5 - std::cos(std::numbers::pi / m) / 4;
    const double doo_sabin = m == 3 ? 0.5 : 0.25;
    bound = std::min(bound, weights == Weights::Averaged ? averaged : doo_sabin);
  }
  return bound;
}

Eigen::VectorXcd eigenvalues(const PolygonMesh& mesh, Weights weights) {
  const MeshTopology topology(mesh);
  const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
  const Subdivision subdivision(topology, features, weights);
  const auto table = limit_masks(subdivision);
  const StencilView<double> view = table.view();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(view.row_count(), view.row_count());
  for (int32_t row = 0; row < view.row_count(); ++row) {
    for (int32_t k = view.offsets[row]; k < view.offsets[row] + view.sizes[row]; ++k) {
      matrix(row, view.indices[k]) += view.weights[k];
    }
  }
  return matrix.eigenvalues();
}

// Darts tie a curve to the faces beside it and not the other way round: pairs become complex, by
// at most this much on seeded meshes where every fifth edge is a crease.
constexpr double kDartImaginary = 0.05;

bool has_darts(const PolygonMesh& mesh) {
  const MeshTopology topology(mesh);
  const SharpFeatures features = find_sharp_features(mesh, topology, mesh.positions, {});
  return std::count(features.vertex_kinds.begin(), features.vertex_kinds.end(), VertexKind::Dart);
}

TEST(Spectrum, LiesWithinTheClosedFormBound) {
  for (const auto& [name, mesh] : all_meshes()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const double bound = closed_form_bound(mesh, weights);
      EXPECT_NEAR(spectral_bound(mesh, weights), bound, 1e-15);
      const Eigen::VectorXcd values = eigenvalues(mesh, weights);
      EXPECT_GE(values.real().minCoeff(), bound - kEigenvalueRounding);
      EXPECT_NEAR(values.real().maxCoeff(), 1, kEigenvalueRounding);
      EXPECT_LE(values.imag().cwiseAbs().maxCoeff(),
                has_darts(mesh) ? kDartImaginary : kEigenvalueRounding);
    }
  }
}

TEST(Spectrum, BoundIsSharpForSingleKindsOfFaces) {
  // Antipodal pairs of a torus of even sizes carry the alternating mode: exactly 1/4.
  const Eigen::VectorXcd values = eigenvalues(torus(8, 6, 1, 0.4), Weights::Averaged);
  EXPECT_NEAR(values.real().minCoeff(), 0.25, kEigenvalueRounding);
}

// Iterations to 1e-5, 1e-6 and 1e-10 of the diagonal in double, against measured counts of an
// independent implementation. One more or less is allowed: the last error may be near a tolerance.

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
  for (const auto& [name, mesh] : all_meshes()) {
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
