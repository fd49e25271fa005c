#include "planish/solve/progressive.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/doosabin/limit_masks.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"

namespace planish {
namespace {

struct Problem {
  explicit Problem(const PolygonMesh& mesh, Weights weights = Weights::DooSabin)
      : topology(mesh),
        features(find_sharp_features(mesh, topology, mesh.positions, {})),
        masks(limit_masks(Subdivision(topology, features, weights))) {
    const Placement placement = placement_of(mesh);
    for (const auto& p : mesh.positions) given.push_back(placement.to_unit(p));
    options.spectral_bound = spectral_bound(mesh, weights);
  }
  Interpolation solve(Backend& backend) const {
    return interpolate(backend, masks.view(), given, options);
  }

  MeshTopology topology;
  SharpFeatures features;
  StencilTable masks;
  std::vector<glm::dvec3> given;
  InterpolationOptions options;
};

Eigen::MatrixXd dense(const StencilView<double>& view) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(view.row_count(), view.source_count);
  for (int i = 0; i < view.row_count(); ++i) {
    for (int k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
      matrix(i, view.indices[k]) += view.weights[k];
    }
  }
  return matrix;
}

TEST(Interpolate, EverySolverFindsEigensSolution) {
  Problem problem(test::icosphere(2));
  const auto row_weights = valences(problem.topology);
  const auto n = static_cast<Eigen::Index>(problem.given.size());
  Eigen::MatrixXd given(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    given.row(i) << problem.given[i].x, problem.given[i].y, problem.given[i].z;
  }
  const Eigen::MatrixXd expected = dense(problem.masks.view()).partialPivLu().solve(given);
  for (const Solver solver : {Solver::Plain, Solver::Chebyshev, Solver::ConjugateGradients}) {
    problem.options.solver = solver;
    problem.options.tolerance = 1e-13;
    problem.options.row_weights = row_weights;
    const Interpolation result = problem.solve(*make_cpu_backend());
    EXPECT_TRUE(result.converged);
    for (Eigen::Index i = 0; i < n; ++i) {
      const glm::dvec3 control = problem.given[i] + result.displacement[i];
      EXPECT_LT(glm::length(control - glm::dvec3(expected(i, 0), expected(i, 1), expected(i, 2))),
                1e-12);
    }
  }
}

// Of a flat mesh the third coordinate has no residual at all, whose ratios would be 0 / 0.
TEST(Interpolate, ConjugateGradientsLeaveACoordinateWithoutResidualAlone) {
  Problem problem(test::icosphere(2));
  const auto row_weights = valences(problem.topology);
  problem.options.row_weights = row_weights;
  problem.options.solver = Solver::ConjugateGradients;
  problem.options.tolerance = 1e-13;
  const Interpolation whole = problem.solve(*make_cpu_backend());
  for (glm::dvec3& p : problem.given) p.z = 0;
  const Interpolation flat = problem.solve(*make_cpu_backend());
  EXPECT_TRUE(flat.converged);
  for (std::size_t i = 0; i < problem.given.size(); ++i) {
    EXPECT_EQ(flat.displacement[i].z, 0);
    EXPECT_NEAR(flat.displacement[i].x, whole.displacement[i].x, 1e-12);
    EXPECT_NEAR(flat.displacement[i].y, whole.displacement[i].y, 1e-12);
  }
}

TEST(Interpolate, PlainIsThePapersIteration) {
  // V <- V + (V0 - B V), written down.
  Problem problem(test::cube());
  problem.options.solver = Solver::Plain;
  problem.options.max_iterations = 3;
  problem.options.tolerance = 1e-15;
  const Eigen::MatrixXd b = dense(problem.masks.view());
  Eigen::MatrixXd given(8, 3);
  for (int i = 0; i < 8; ++i) {
    given.row(i) << problem.given[i].x, problem.given[i].y, problem.given[i].z;
  }
  Eigen::MatrixXd v = given;
  for (int k = 0; k < 3; ++k) v += given - b * v;
  const Interpolation result = problem.solve(*make_cpu_backend());
  EXPECT_EQ(result.iterations, 3);
  EXPECT_EQ(result.stop_reason, StopReason::IterationLimit);
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.history.size(), 4u);
  for (int i = 0; i < 8; ++i) {
    EXPECT_NEAR((problem.given[i] + result.displacement[i]).x, v(i, 0), 1e-15);
  }
  EXPECT_NEAR(result.error.max, (given - b * v).rowwise().norm().maxCoeff(), 1e-15);
  EXPECT_NEAR(result.history.back().max, result.error.max, 1e-15);
}

TEST(Interpolate, NeedsNoStepWhereTheErrorIsLowAlready) {
  Problem problem(test::torus(64, 32, 1.0, 0.4));
  problem.options.tolerance = 1e-2;
  const Interpolation result = problem.solve(*make_cpu_backend());
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.iterations, 0);
  EXPECT_EQ(result.history.size(), 1u);
  EXPECT_NEAR(result.history[0].max, 8.9e-4, 0.05e-4);
}

class CountedSteps : public StepSolve {
 public:
  explicit CountedSteps(StepSolve& solve) : solve_(solve) {}
  StepLog run(std::span<const StepCoefficients> steps, double stop_error) override {
    batches.push_back(std::ssize(steps));
    return solve_.run(steps, stop_error);
  }
  ErrorNorms error() override { return solve_.error(); }

  std::vector<std::ptrdiff_t> batches;

 private:
  StepSolve& solve_;
};

// All at once, for a device does them without talking to the host. k steps leave 2 sigma^k, with
// sigma = (1 - sqrt b) / (1 + sqrt b) of the spectral bound b (Golub and Varga 1961).
TEST(Interpolate, ChebyshevOrdersTheStepsOfItsBound) {
  for (const double tolerance : {1e-4, 1e-7, 1e-10}) {
    Problem problem(test::icosphere(2));
    problem.options.tolerance = tolerance;
    const auto backend = make_cpu_backend({.solve_precision = Precision::Double});
    const SummedView masks(problem.masks.view());
    const auto solve = backend->make_solve(masks);
    std::vector<glm::dvec3> residual;
    double initial = 0;
    const Eigen::MatrixXd b = dense(problem.masks.view());
    for (Eigen::Index i = 0; i < b.rows(); ++i) {
      glm::dvec3 limit(0.0);
      for (Eigen::Index j = 0; j < b.cols(); ++j) limit += b(i, j) * problem.given[j];
      residual.push_back(problem.given[i] - limit);
      initial = std::max(initial, glm::length(residual.back()));
    }
    solve->begin(residual);
    CountedSteps counted(*solve);
    Interpolation result;
    take_steps(counted, initial, problem.options, result);
    EXPECT_EQ(result.stop_reason, StopReason::Converged);
    const double root = std::sqrt(problem.options.spectral_bound);
    ASSERT_EQ(counted.batches.size(), 1u);
    EXPECT_EQ(counted.batches[0],
              std::ceil(std::log(0.5 * tolerance / initial) / std::log((1 - root) / (1 + root))));
  }
}

TEST(Interpolate, TakesNoStepWhereNoneIsAllowed) {
  Problem problem(test::icosphere(2));
  const auto row_weights = valences(problem.topology);
  problem.options.row_weights = row_weights;
  problem.options.max_iterations = 0;
  for (const Solver solver : {Solver::Plain, Solver::Chebyshev, Solver::ConjugateGradients}) {
    problem.options.solver = solver;
    const Interpolation result = problem.solve(*make_cpu_backend());
    EXPECT_FALSE(result.converged);
    EXPECT_EQ(result.iterations, 0);
    EXPECT_EQ(result.stop_reason, StopReason::IterationLimit);
  }
}

TEST(Interpolate, SinglePrecisionReportsWhatItCannotReach) {
  Problem problem(test::icosphere(3));
  problem.options.tolerance = 1e-13;
  for (const Solver solver : {Solver::Plain, Solver::Chebyshev}) {
    problem.options.solver = solver;
    const Interpolation result = problem.solve(*make_cpu_backend({Precision::Float}));
    EXPECT_FALSE(result.converged);
    EXPECT_EQ(result.stop_reason, StopReason::Stagnated);
    EXPECT_LT(result.error.max, 1e-9) << "the displacement form keeps nine digits";
  }
}

TEST(Interpolate, ReportsDivergenceAndSingularity) {
  // Diagonal matrices: 3 makes the plain iteration diverge, 0 leaves its row where it is.
  const auto diagonal = [](double value) {
    StencilTable rows;
    rows.sizes = {2, 2};
    rows.indices = {0, 1, 0, 1};
    rows.weights = {1, 0, 1 - value, value};
    rows.close(2);
    return rows;
  };
  const std::vector<glm::dvec3> given{{0, 0, 0}, {0.5, 0, 0}};
  InterpolationOptions options;
  options.solver = Solver::Plain;
  options.max_iterations = 1000;
  const auto backend = make_cpu_backend();
  const auto diverging = interpolate(*backend, diagonal(3).view(), given, options);
  EXPECT_EQ(diverging.stop_reason, StopReason::Diverged);
  EXPECT_FALSE(diverging.converged);
  const auto singular = interpolate(*backend, diagonal(0).view(), given, options);
  EXPECT_EQ(singular.stop_reason, StopReason::Stagnated);
  EXPECT_FALSE(singular.converged);
  EXPECT_EQ(singular.worst_vertex, 1);
}

// Conjugate gradients take no indefinite system: both residuals are 1, and the step that
// 2 / (0.5 - 0.4999) asks for throws them far off.
TEST(Interpolate, ConjugateGradientsReportDivergence) {
  StencilTable rows;
  rows.sizes = {1, 2, 2};
  rows.indices = {0, 0, 1, 0, 2};
  rows.weights = {1, 0.5, 0.5, 1.4999, -0.4999};
  rows.close(3);
  InterpolationOptions options;
  options.solver = Solver::ConjugateGradients;
  const std::vector<double> row_weights(3, 1.0);
  options.row_weights = row_weights;
  const std::vector<glm::dvec3> given{{0, 0, 0}, {2, 0, 0}, {1 / 1.4999, 0, 0}};
  const auto result = interpolate(*make_cpu_backend(), rows.view(), given, options);
  EXPECT_EQ(result.stop_reason, StopReason::Diverged);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_FALSE(result.converged);
}

TEST(Interpolate, RefusesAToleranceThatIsNotPositive) {
  Problem problem(test::cube());
  const auto backend = make_cpu_backend();
  for (const double tolerance : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    problem.options.tolerance = tolerance;
    EXPECT_THROW((void)problem.solve(*backend), Error);
  }
}

TEST(Interpolate, CanBeCancelled) {
  Problem problem(test::icosphere(2));
  problem.options.callbacks.cancelled = [] { return true; };
  try {
    (void)problem.solve(*make_cpu_backend());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Cancelled);
  }
}

}  // namespace
}  // namespace planish
