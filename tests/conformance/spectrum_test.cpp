// Eigenvalues of the limit-mask matrix by dense linear algebra.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "conformance/catalogue.h"
#include "planish/doosabin/limit_masks.h"

namespace planish::test {
namespace {

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

void expect_spectrum_in_bounds(const std::vector<NamedMesh>& meshes) {
  for (const auto& [name, mesh] : meshes) {
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

TEST(Spectrum, ClosedMeshesLieWithinTheClosedFormBound) {
  expect_spectrum_in_bounds(closed_meshes());
}

TEST(Spectrum, BoundIsSharpForSingleKindsOfFaces) {
  // Antipodal pairs of a torus of even sizes carry the alternating mode: exactly 1/4.
  const Eigen::VectorXcd values = eigenvalues(torus(8, 6, 1, 0.4), Weights::Averaged);
  EXPECT_NEAR(values.real().minCoeff(), 0.25, kEigenvalueRounding);
}

TEST(Spectrum, OpenMeshesLieWithinTheClosedFormBound) { expect_spectrum_in_bounds(open_meshes()); }

TEST(Spectrum, SharpMeshesLieWithinTheClosedFormBound) {
  expect_spectrum_in_bounds(sharp_meshes());
}

}  // namespace
}  // namespace planish::test
