// What the iterations rely on, against dense linear algebra.
#include "planish/primal/primal_stencils.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "planish/primal/primal_stencils.h"
#include "support/primal_meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using std::int32_t;

struct System {
  Eigen::MatrixXd matrix;
  Spectrum spectrum;
  std::vector<double> weights;
};

System system_of(const PolygonMesh& mesh, PrimalScheme scheme) {
  PrimalSplit split(mesh, {scheme, {}});
  split.refine(1);
  const auto table = primal_limit_masks(split);
  const StencilView<double> view = table.view();
  System system;
  system.matrix = Eigen::MatrixXd::Zero(view.row_count(), view.row_count());
  for (int32_t row = 0; row < view.row_count(); ++row) {
    for (int32_t k = view.offsets[row]; k < view.offsets[row] + view.sizes[row]; ++k) {
      system.matrix(row, view.indices[k]) += view.weights[k];
    }
  }
  system.spectrum = primal_spectrum(split, view);
  system.weights = primal_row_weights(split);
  return system;
}

class PrimalSpectrum : public testing::TestWithParam<PrimalScheme> {};

TEST_P(PrimalSpectrum, IsBoundedAsClaimed) {
  for (const auto& [name, mesh] : primal_meshes(GetParam())) {
    SCOPED_TRACE(name);
    const System system = system_of(mesh, GetParam());
    const Eigen::VectorXcd values = system.matrix.eigenvalues();
    const double smallest = values.real().minCoeff();
    const double imaginary = values.imag().cwiseAbs().maxCoeff();
    EXPECT_LT(values.real().maxCoeff(), 1 + 1e-9);
    if (system.spectrum.proven) {
      EXPECT_GE(smallest, system.spectrum.smallest - 1e-9);
      EXPECT_LT(imaginary, 1e-6);
    }
    // Darts and semi-sharp edges tie a curve to the faces beside it and not the other way round.
    EXPECT_LT(imaginary, 0.05);
    if (system.spectrum.smallest > 0.01) {
      EXPECT_GT(smallest, 0);
    }
    if (system.spectrum.self_adjoint) {
      const Eigen::VectorXd weights =
          Eigen::Map<const Eigen::VectorXd>(system.weights.data(), system.matrix.rows());
      const Eigen::MatrixXd scaled = weights.asDiagonal() * system.matrix;
      EXPECT_LT((scaled - scaled.transpose()).cwiseAbs().maxCoeff(), 1e-12);
      if (!system.spectrum.proven) {
        EXPECT_NEAR(smallest, system.spectrum.smallest, 0.02);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, PrimalSpectrum, testing::ValuesIn(kBothPrimalSchemes),
                         [](const auto& test) {
                           return test.param == PrimalScheme::Loop ? "Loop" : "CatmullClark";
                         });

// Eigenvalues 0, 1/6, 1/2 and 1.
TEST(Spectrum, CatmullClarkIsSingularOnTheCube) {
  const System system = system_of(cube(), PrimalScheme::CatmullClark);
  EXPECT_NEAR(system.spectrum.smallest, 0, 1e-12);
  EXPECT_FALSE(system.spectrum.proven);
}

TEST(Spectrum, RegularMeshesMeetTheBound) {
  const System quads = system_of(torus(12, 12, 1, 0.4), PrimalScheme::CatmullClark);
  EXPECT_NEAR(quads.spectrum.smallest, 1.0 / 9, 1e-12);
  EXPECT_NEAR(quads.matrix.eigenvalues().real().minCoeff(), 1.0 / 9, 1e-9);
  const System triangles = system_of(as_triangles(torus(12, 12, 1, 0.4)), PrimalScheme::Loop);
  EXPECT_NEAR(triangles.spectrum.smallest, 1.0 / 4, 1e-12);
  EXPECT_NEAR(triangles.matrix.eigenvalues().real().minCoeff(), 1.0 / 4, 1e-9);
}

}  // namespace
}  // namespace planish::test
