#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <glm/geometric.hpp>
#include <memory>
#include <stdexcept>

#include "bench/agreement.h"
#include "bench/bench_meshes.h"
#include "bench/benchmarks.h"
#include "bench/prepared_mesh.h"
#include "planish/backend/cpu_backend.h"
#include "planish/interpolate/progressive.h"

namespace planish::bench {

namespace {

constexpr double kTolerance = 1e-6;  // of the maximum error, in unit coordinates

using Points = std::vector<glm::dvec3>;
using Matrix = Eigen::SparseMatrix<double>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;
using Cholesky = Eigen::SimplicialLDLT<Matrix>;
using ConjugateGradient = Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>,
                                                   Eigen::Lower | Eigen::Upper>;

// B = A T with A = diag(1 / valence) and T symmetric: B d = r becomes T d = A^-1 r.
struct SymmetricSystem {
  explicit SymmetricSystem(const PreparedMesh& prepared) {
    const StencilView<double> view = prepared.masks.view();
    std::vector<Eigen::Triplet<double>> entries;
    right.resize(view.row_count(), 3);
    for (std::int32_t i = 0; i < view.row_count(); ++i) {
      const double valence = prepared.valence[i];
      glm::dvec3 residual(0.0);
      for (std::int32_t k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
        entries.emplace_back(i, view.indices[k], valence * view.weights[k]);
        residual += view.weights[k] * (prepared.given[i] - prepared.given[view.indices[k]]);
      }
      for (int k = 0; k < 3; ++k) right(i, k) = valence * residual[k];
    }
    matrix.resize(view.row_count(), view.row_count());
    matrix.setFromTriplets(entries.begin(), entries.end());
    rows = matrix;
  }

  Matrix matrix;
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows;
  Columns right;
};

Points control_points(const PreparedMesh& prepared, const Columns& displacement) {
  Points points = prepared.given;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = displacement.row(static_cast<Eigen::Index>(i));
    points[i] += glm::dvec3(row[0], row[1], row[2]);
  }
  return points;
}

double largest_error(const PreparedMesh& prepared, const Points& control) {
  const Points limits = prepared.limits_of(control);
  double largest = 0;
  for (std::size_t i = 0; i < limits.size(); ++i) {
    largest = std::max(largest, glm::length(limits[i] - prepared.given[i]));
  }
  return largest;
}

Points planish_solution(const PreparedMesh& prepared, Backend& backend, Solver solver) {
  InterpolationOptions options;
  options.solver = solver;
  options.tolerance = kTolerance;
  options.spectral_bound = prepared.bound;
  if (solver == Solver::ConjugateGradients) options.row_weights = prepared.valence;
  const Interpolation result = interpolate(backend, prepared.masks.view(), prepared.given, options);
  if (!result.converged) throw std::runtime_error("solve: planish has not converged");
  Points points = prepared.given;
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += result.displacement[i];
  return points;
}

Peer planish_peer(const std::string& name, const PreparedMesh& prepared,
                  std::shared_ptr<Backend> backend, Solver solver, const Points& exact) {
  require_agreement(name, planish_solution(prepared, *backend, solver), exact);
  return {name,
          [&prepared, backend, solver] { (void)planish_solution(prepared, *backend, solver); }};
}

// Eigen stops at a relative residual: the loosest of these that meets our tolerance is used.
Peer conjugate_gradient_peer(const PreparedMesh& prepared, const SymmetricSystem& system,
                             const Points& exact) {
  double tolerance = 0.15;
  while (tolerance > 1e-12) {
    tolerance /= 1.5;
    const auto solution = [&system, tolerance] {
      ConjugateGradient solver;
      solver.setTolerance(tolerance);
      solver.compute(system.rows);
      return Columns(solver.solve(system.right));
    };
    const Points points = control_points(prepared, solution());
    if (largest_error(prepared, points) > kTolerance) continue;
    require_agreement("eigen-cg", points, exact);
    return {"eigen-cg", [solution] { (void)solution(); }};
  }
  throw std::runtime_error("solve: Eigen's conjugate gradients do not converge");
}

std::vector<Row> bench_solves_of(const std::string& name, PolygonMesh mesh, int repetitions) {
  const PreparedMesh prepared(std::move(mesh));
  const SymmetricSystem system(prepared);
  const auto factored = std::make_shared<Cholesky>(system.matrix);
  const Points exact = control_points(prepared, factored->solve(system.right));
  if (largest_error(prepared, exact) > kTolerance) {
    throw std::runtime_error("solve: Eigen's factorisation does not solve the system");
  }

  const auto on_float = std::shared_ptr<Backend>(make_cpu_backend({Precision::Float, 0}));
  const auto on_double = std::shared_ptr<Backend>(make_cpu_backend({Precision::Double, 0}));
  Group group;
  group.name = name;
  group.size = std::to_string(prepared.mesh.vertex_count()) + " vertices, " +
               std::to_string(prepared.masks.weights.size()) + " entries";
  group.baseline = "planish-chebyshev";
  group.peers = {
      planish_peer("planish-chebyshev", prepared, on_double, Solver::Chebyshev, exact),
      planish_peer("planish-chebyshev-float", prepared, on_float, Solver::Chebyshev, exact),
      planish_peer("planish-plain", prepared, on_double, Solver::Plain, exact),
      planish_peer("planish-cg", prepared, on_double, Solver::ConjugateGradients, exact),
      conjugate_gradient_peer(prepared, system, exact),
      {"eigen-ldlt",
       [&system] {
         const Cholesky solver(system.matrix);
         (void)Columns(solver.solve(system.right));
       }},
      {"eigen-ldlt-solve-only",
       [&system, factored] { (void)Columns(factored->solve(system.right)); }}};
  return run_group(group, repetitions);
}

// The factorisation of a larger system takes minutes.
constexpr std::int32_t kMostQuads = 100'000;

}  // namespace

std::vector<Row> bench_solve(const Options& options) {
  std::vector<Row> rows = bench_solves_of(
      "solve-torus", torus_grid(std::min(options.quad_count, kMostQuads)), options.repetitions);
  const std::vector<Row> sphere =
      bench_solves_of("solve-sphere", rough_icosphere(options.sphere_level), options.repetitions);
  rows.insert(rows.end(), sphere.begin(), sphere.end());
  return rows;
}

}  // namespace planish::bench
