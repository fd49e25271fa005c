#include "planish/distributed/petsc_solve.h"

#include <gtest/gtest.h>
#include <petscksp.h>

#include "distributed/rank_runs.h"
#include "planish/solve/iteration.h"

namespace planish::test {
namespace {

struct System {
  Layout layout;
  PartRows rows;
  std::vector<glm::dvec3> given;
  std::int64_t vertices = 0;
  std::vector<std::int64_t> file_ids;
};

System system_of(const Ranks& ranks, const PolygonMesh& mesh) {
  MeshSlice slice = scatter_mesh(ranks, mesh);
  CurveOrder order = order_along_curve(ranks, slice, 16);
  FaceStream ring = send_first_ring(ranks, slice, order);
  MeshPart part = make_part(ranks, std::move(ring), slice, std::move(order));
  System system;
  system.rows = make_rows(ranks, part, "mesh", mesh.face_count(), {.block_vertices = 16});
  system.layout = part.layout;
  system.file_ids.assign(part.file_ids.begin(), part.file_ids.begin() + part.owned_count());
  system.given.assign(part.positions.begin(), part.positions.begin() + part.owned_count());
  system.vertices = mesh.vertex_count();
  return system;
}

// The same system by PETSc's own matrices, of which MAIJ takes three columns at once.
std::vector<glm::dvec3> solved_by_maij(const Ranks& ranks, const System& system, int steps) {
  const PartRows& rows = system.rows;
  const PetscInt own = rows.row_count(), first = system.layout[ranks.rank];
  std::vector<PetscInt> offsets(rows.offsets.begin(), rows.offsets.end()), columns;
  for (const std::int32_t column : rows.columns)
    columns.push_back(column < own ? first + column : rows.ghosts[column - own]);
  Mat aij, maij;
  Vec b, d;
  KSP ksp;
  PC pc;
  MatCreateMPIAIJWithArrays(ranks.comm, own, own, PETSC_DETERMINE, PETSC_DETERMINE, offsets.data(),
                            columns.data(), rows.weights.data(), &aij);
  MatCreateMAIJ(aij, 3, &maij);
  VecCreateMPI(ranks.comm, 3 * own, PETSC_DETERMINE, &b);
  VecDuplicate(b, &d);
  double* values = nullptr;
  VecGetArrayWrite(b, &values);
  for (PetscInt v = 0; v < own; ++v) {
    glm::dvec3 sum(0.0);
    for (std::int64_t k = rows.offsets[v]; k < rows.offsets[v + 1]; ++k) {
      const std::int32_t c = rows.columns[k];
      sum += rows.weights[k] *
             (system.given[v] - (c < own ? system.given[c] : rows.ghost_points[c - own]));
    }
    for (int c = 0; c < 3; ++c) values[3 * v + c] = sum[c];
  }
  VecRestoreArrayWrite(b, &values);
  KSPCreate(ranks.comm, &ksp);
  KSPSetOperators(ksp, maij, maij);
  KSPGetPC(ksp, &pc);
  PCSetType(pc, PCNONE);
  KSPSetType(ksp, KSPCHEBYSHEV);
  KSPChebyshevSetEigenvalues(ksp, 1.0, rows.spectral_bound);
  KSPSetNormType(ksp, KSP_NORM_NONE);
  KSPSetConvergenceTest(ksp, KSPConvergedSkip, nullptr, nullptr);
  KSPSetTolerances(ksp, 0, 0, PETSC_DEFAULT, steps);
  KSPSolve(ksp, b, d);
  std::vector<glm::dvec3> result;
  const double* solved = nullptr;
  VecGetArrayRead(d, &solved);
  for (PetscInt v = 0; v < own; ++v)
    result.push_back({solved[3 * v], solved[3 * v + 1], solved[3 * v + 2]});
  VecRestoreArrayRead(d, &solved);
  KSPDestroy(&ksp);
  VecDestroy(&d);
  VecDestroy(&b);
  MatDestroy(&maij);
  MatDestroy(&aij);
  return result;
}

TEST(PetscSolve, AgreesWithPetscsOwnMatrices) {
  const PolygonMesh mesh = mixed_torus(32, 16);
  for (const int count : kRankCounts)
    on_ranks(count, [&](const Ranks& ranks) {
      const System system = system_of(ranks, mesh);
      // Unit coordinates differ from these by less than a factor of 4.
      const PetscSolution solution =
          petsc_solve(ranks, system.layout, system.rows, system.given, system.rows.ghost_points,
                      system.vertices, {.tolerance = 1e-6, .block_vertices = 16});
      EXPECT_TRUE(solution.converged);
      EXPECT_EQ(std::ssize(solution.history), solution.iterations + 1);
      const auto expected = solved_by_maij(ranks, system, solution.iterations);
      for (std::size_t v = 0; v < expected.size(); ++v)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(solution.displacement[v][c], expected[v][c], 1e-15);
    });
}

TEST(PetscSolve, PlainIterationIsThePapers) {
  const PolygonMesh mesh = mixed_torus(16, 8);
  on_ranks(1, [&](const Ranks& ranks) {
    const System system = system_of(ranks, mesh);
    const PetscSolution solution = petsc_solve(
        ranks, system.layout, system.rows, system.given, system.rows.ghost_points, system.vertices,
        {.solver = Solver::Plain, .tolerance = 1e-20, .max_iterations = 8, .block_vertices = 16});
    EXPECT_EQ(solution.iterations, 8);
    EXPECT_EQ(solution.stop_reason, StopReason::IterationLimit);
    // V <- V + (V0 - B V), eight times.
    std::vector<glm::dvec3> control = system.given;
    const PartRows& rows = system.rows;
    for (int step = 0; step < 8; ++step) {
      std::vector<glm::dvec3> next = control;
      for (std::int32_t v = 0; v < rows.row_count(); ++v) {
        glm::dvec3 limit(0.0);
        for (std::int64_t k = rows.offsets[v]; k < rows.offsets[v + 1]; ++k)
          limit += rows.weights[k] * control[rows.columns[k]];
        next[v] += system.given[v] - limit;
      }
      control = next;
    }
    for (std::size_t v = 0; v < control.size(); ++v)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(system.given[v][c] + solution.displacement[v][c], control[v][c], 1e-14);
  });
}

TEST(PetscSolve, AnUnreachableToleranceStagnates) {
  on_ranks(3, [&](const Ranks& ranks) {
    const System system = system_of(ranks, mixed_torus(16, 8));
    const PetscSolution solution =
        petsc_solve(ranks, system.layout, system.rows, system.given, system.rows.ghost_points,
                    system.vertices, {.tolerance = 1e-30, .block_vertices = 16});
    EXPECT_FALSE(solution.converged);
    EXPECT_EQ(solution.stop_reason, StopReason::Stagnated);
    EXPECT_LT(solution.error.max, 1e-15);
    const Outcome refused = outcome_of([&] {
      (void)petsc_solve(ranks, system.layout, system.rows, system.given, system.rows.ghost_points,
                        system.vertices, {.solver = Solver::ConjugateGradients});
    });
    EXPECT_EQ(refused.code, static_cast<int>(ErrorCode::InvalidArgument));
  });
}

}  // namespace
}  // namespace planish::test
