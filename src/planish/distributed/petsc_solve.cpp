// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3.2, and
// Golub & Varga, "Chebyshev semi-iterative methods", 1961, both as PETSc's KSP has them.
// The system is B d = r_0 with r_0 = V0 - B V0 taken from differences, as on one machine.
#include "planish/distributed/petsc_solve.h"

#include <petscksp.h>
#include <petscsf.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <limits>
#include <stdexcept>

#include "planish/backend/chebyshev.h"
#include "planish/core/parallel.h"

namespace planish {

namespace {

constexpr std::size_t kGrain = 4096;
// Steps of a batch behind the first, which has the count that the bound promises.
constexpr std::int32_t kMoreChebyshevSteps = 3;
constexpr std::int32_t kPlainSteps = 4;
// After so many steps that gain less than this factor no progress is made, as on one machine.
constexpr std::int32_t kStagnationSteps = 32;
constexpr double kStagnationFactor = 0.9;
constexpr double kDivergenceFactor = 1e3;

void require(PetscErrorCode code) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw std::runtime_error("PETSc: error " + std::to_string(code) + ", " +
                           (text != nullptr ? text : "without a text"));
}

// A PETSc object that is destroyed with this.
template <class Object, PetscErrorCode (*destroy)(Object*)>
class Owned {
 public:
  Owned() = default;
  ~Owned() { (void)destroy(&object_); }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  operator Object() const { return object_; }
  Object* operator&() { return &object_; }

 private:
  Object object_ = nullptr;
};

class Triple {
 public:
  Triple() {
    MPI_Type_contiguous(3, MPI_DOUBLE, &type_);
    MPI_Type_commit(&type_);
  }
  ~Triple() { MPI_Type_free(&type_); }
  Triple(const Triple&) = delete;
  Triple& operator=(const Triple&) = delete;
  operator MPI_Datatype() const { return type_; }

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

// y = B x for three columns at once. Rows without ghosts are done while ghosts are on their way.
class Kernel {
 public:
  Kernel(const Ranks& ranks, const Layout& layout, const PartRows& rows)
      : rows_(rows), ghosts_(3 * rows.ghosts.size()) {
    const std::int32_t owned = rows.row_count();
    std::vector<PetscSFNode> remote(rows.ghosts.size());
    for (std::size_t g = 0; g < remote.size(); ++g) {
      const int owner = owner_of(layout, rows.ghosts[g]);
      remote[g] = {owner, static_cast<PetscInt>(rows.ghosts[g] - layout[owner])};
      if (g == 0 || remote[g - 1].rank != owner) ++peers_;
    }
    require(PetscSFCreate(ranks.comm, &halo_));
    require(PetscSFSetGraph(halo_, owned, static_cast<PetscInt>(remote.size()), nullptr,
                            PETSC_COPY_VALUES, remote.data(), PETSC_COPY_VALUES));
    require(PetscSFSetUp(halo_));
    for (std::int32_t row = 0; row < owned; ++row) {
      bool names_ghost = false;
      for (std::int64_t k = rows.offsets[row]; k < rows.offsets[row + 1]; ++k)
        names_ghost |= rows.columns[k] >= owned;
      (names_ghost ? outer_ : inner_).push_back(row);
    }
  }

  [[nodiscard]] std::int32_t peers() const { return peers_; }

  [[nodiscard]] PetscErrorCode apply(const double* x, double* y) {
    PetscCall(PetscSFBcastBegin(halo_, triple_, x, ghosts_.data(), MPI_REPLACE));
    multiply<false>(inner_, x, y);
    PetscCall(PetscSFBcastEnd(halo_, triple_, x, ghosts_.data(), MPI_REPLACE));
    multiply<true>(outer_, x, y);
    return 0;
  }

 private:
  template <bool kGhosts>
  void multiply(const std::vector<std::int32_t>& list, const double* x, double* y) const {
    const std::int32_t owned = rows_.row_count();
    parallel_for(list.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::int32_t row = list[i];
        double sum0 = 0, sum1 = 0, sum2 = 0;
        for (std::int64_t k = rows_.offsets[row]; k < rows_.offsets[row + 1]; ++k) {
          const std::int32_t column = rows_.columns[k];
          const double weight = rows_.weights[k];
          const double* point = !kGhosts || column < owned
                                    ? x + 3 * static_cast<std::size_t>(column)
                                    : ghosts_.data() + 3 * static_cast<std::size_t>(column - owned);
          sum0 += weight * point[0];
          sum1 += weight * point[1];
          sum2 += weight * point[2];
        }
        double* out = y + 3 * static_cast<std::size_t>(row);
        out[0] = sum0;
        out[1] = sum1;
        out[2] = sum2;
      }
    });
  }

  const PartRows& rows_;
  Owned<PetscSF, PetscSFDestroy> halo_;
  Triple triple_;
  std::vector<double> ghosts_;
  std::vector<std::int32_t> inner_, outer_;
  std::int32_t peers_ = 0;
};

PetscErrorCode shell_multiply(Mat matrix, Vec x, Vec y) {
  Kernel* kernel = nullptr;
  const double* in = nullptr;
  double* out = nullptr;
  PetscCall(MatShellGetContext(matrix, &kernel));
  PetscCall(VecGetArrayRead(x, &in));
  PetscCall(VecGetArrayWrite(y, &out));
  PetscCall(kernel->apply(in, out));
  PetscCall(VecRestoreArrayWrite(y, &out));
  PetscCall(VecRestoreArrayRead(x, &in));
  return 0;
}

// sum_j b_ij (given_i - given_j): rounding is relative to the differences.
void set_right_hand_side(Vec b, const PartRows& rows, std::span<const glm::dvec3> given,
                         std::span<const glm::dvec3> ghosts) {
  double* out = nullptr;
  require(VecGetArrayWrite(b, &out));
  const std::int32_t owned = rows.row_count();
  parallel_for(given.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      glm::dvec3 sum(0.0);
      for (std::int64_t k = rows.offsets[row]; k < rows.offsets[row + 1]; ++k) {
        const std::int32_t column = rows.columns[k];
        const glm::dvec3& other = column < owned ? given[column] : ghosts[column - owned];
        sum += rows.weights[k] * (given[row] - other);
      }
      for (int c = 0; c < 3; ++c) out[3 * row + c] = sum[c];
    }
  });
  require(VecRestoreArrayWrite(b, &out));
}

class Iteration {
 public:
  Iteration(const Ranks& ranks, const Layout& layout, const PartRows& rows,
            const PetscSolveOptions& options)
      : ranks_(ranks), rows_(rows), options_(options), kernel_(ranks, layout, rows) {
    const PetscInt own = 3 * static_cast<PetscInt>(rows.row_count());
    require(VecCreate(ranks.comm, &b_));
    require(VecSetSizes(b_, own, PETSC_DETERMINE));
    require(VecSetType(b_, VECMPI));
    require(VecDuplicate(b_, &d_));
    require(VecDuplicate(b_, &work_));
    require(VecSet(d_, 0));
    require(
        MatCreateShell(ranks.comm, own, own, PETSC_DETERMINE, PETSC_DETERMINE, &kernel_, &shell_));
    require(
        MatShellSetOperation(shell_, MATOP_MULT, reinterpret_cast<void (*)(void)>(shell_multiply)));
    make_solver();
  }

  PetscSolution run(std::span<const glm::dvec3> given, std::span<const glm::dvec3> ghosts,
                    std::int64_t used_total) {
    set_right_hand_side(b_, rows_, given, ghosts);
    PetscSolution solution;
    solution.peers = kernel_.peers();
    measure(b_, solution);
    const double initial = solution.error.max;
    std::int32_t batch = first_batch(initial), since_progress = 0;
    double best = initial;
    solution.stop_reason = StopReason::IterationLimit;
    while (solution.error.max > options_.tolerance &&
           solution.iterations < options_.max_iterations) {
      batch = std::min(batch, options_.max_iterations - solution.iterations);
      step(batch, solution.iterations > 0);
      solution.iterations += batch;
      require(MatMult(shell_, d_, work_));
      require(VecAYPX(work_, -1.0, b_));
      measure(work_, solution);
      if (options_.after_batch) options_.after_batch();
      const double error = solution.error.max;
      since_progress = error <= kStagnationFactor * best ? 0 : since_progress + batch;
      best = std::min(best, error);
      if (!(error <= kDivergenceFactor * initial)) {
        solution.stop_reason = StopReason::Diverged;
        break;
      }
      if (since_progress >= kStagnationSteps && error > options_.tolerance) {
        solution.stop_reason = StopReason::Stagnated;
        break;
      }
      batch = options_.solver == Solver::Chebyshev ? kMoreChebyshevSteps : kPlainSteps;
    }
    solution.converged = solution.error.max <= options_.tolerance;
    if (solution.converged) solution.stop_reason = StopReason::Converged;
    solution.error.rms = mean_square_root(used_total);
    take_displacement(solution);
    return solution;
  }

 private:
  void make_solver() {
    PC pc = nullptr;
    require(KSPCreate(ranks_.comm, &ksp_));
    require(KSPSetOperators(ksp_, shell_, shell_));
    require(KSPGetPC(ksp_, &pc));
    require(PCSetType(pc, PCNONE));
    // No norm and no test: a count of steps is all that is wanted, and nothing is reduced.
    require(KSPSetNormType(ksp_, KSP_NORM_NONE));
    require(KSPSetConvergenceTest(ksp_, KSPConvergedSkip, nullptr, nullptr));
    if (options_.solver == Solver::Chebyshev) {
      require(KSPSetType(ksp_, KSPCHEBYSHEV));
      // The largest first. Without it PETSc estimates, for smoothing.
      require(KSPChebyshevSetEigenvalues(ksp_, 1.0, rows_.spectral_bound));
    } else {
      require(KSPSetType(ksp_, KSPRICHARDSON));
      require(KSPRichardsonSetScale(ksp_, 1.0));
    }
  }

  [[nodiscard]] std::int32_t first_batch(double initial) const {
    if (options_.solver != Solver::Chebyshev) return 2 * kPlainSteps;
    const double count = chebyshev_step_count(rows_.spectral_bound, options_.tolerance / initial);
    return static_cast<std::int32_t>(std::clamp<double>(count, 1, options_.max_iterations));
  }

  void step(std::int32_t count, bool goes_on) {
    require(KSPSetTolerances(ksp_, 0, 0, PETSC_DEFAULT, count));
    require(KSPSetInitialGuessNonzero(ksp_, goes_on ? PETSC_TRUE : PETSC_FALSE));
    require(KSPSolve(ksp_, b_, d_));
  }

  // One maximum over all ranks. Sums of squares, one a block, are kept for the end.
  void measure(Vec residual, PetscSolution& solution) {
    const double* values = nullptr;
    require(VecGetArrayRead(residual, &values));
    const auto rows = static_cast<std::int64_t>(rows_.row_count());
    const std::int64_t block = options_.block_vertices;
    block_sums_.assign(static_cast<std::size_t>((rows + block - 1) / block), 0.0);
    std::vector<double> largest(block_sums_.size(), 0.0);
    parallel_for(block_sums_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) {
        const std::int64_t first = static_cast<std::int64_t>(p) * block;
        for (std::int64_t row = first; row < std::min(first + block, rows); ++row) {
          const double* v = values + 3 * row;
          double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
          if (!std::isfinite(square)) square = std::numeric_limits<double>::infinity();
          block_sums_[p] += square;
          largest[p] = std::max(largest[p], square);
        }
      }
    });
    require(VecRestoreArrayRead(residual, &values));
    const double most = largest.empty() ? 0.0 : std::ranges::max(largest);
    solution.error.max = std::sqrt(max_over(ranks_, most));
    ++solution.reductions;
    solution.history.push_back(solution.error.max);
  }

  // Added in the order of blocks, so that the sum has the same bits for every rank count.
  [[nodiscard]] double mean_square_root(std::int64_t used_total) const {
    std::vector<std::int64_t> counts(static_cast<std::size_t>(ranks_.size), 0);
    counts[0] = static_cast<std::int64_t>(block_sums_.size());
    double sum = 0;
    for (const double piece : all_to_all<double>(ranks_, block_sums_, counts)) sum += piece;
    return used_total > 0 ? std::sqrt(sum / static_cast<double>(used_total)) : 0.0;
  }

  void take_displacement(PetscSolution& solution) {
    const double* values = nullptr;
    require(VecGetArrayRead(d_, &values));
    solution.displacement.resize(static_cast<std::size_t>(rows_.row_count()));
    for (std::size_t v = 0; v < solution.displacement.size(); ++v)
      solution.displacement[v] = {values[3 * v], values[3 * v + 1], values[3 * v + 2]};
    require(VecRestoreArrayRead(d_, &values));
  }

  const Ranks& ranks_;
  const PartRows& rows_;
  const PetscSolveOptions& options_;
  Kernel kernel_;
  Owned<Vec, VecDestroy> b_, d_, work_;
  Owned<Mat, MatDestroy> shell_;
  Owned<KSP, KSPDestroy> ksp_;
  std::vector<double> block_sums_;  // of the last residual measured
};

}  // namespace

PetscSession::PetscSession() {
  unsetenv("PETSC_OPTIONS");
  static char program[] = "planish-mpi", skip[] = "-skip_petscrc";
  static char* list[] = {program, skip, nullptr};
  int count = 2;
  char** arguments = list;
  require(PetscInitialize(&count, &arguments, nullptr, nullptr));
  require(PetscPopSignalHandler());
  require(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
}

PetscSession::~PetscSession() { (void)PetscFinalize(); }

std::string PetscSession::version() {
  return std::to_string(PETSC_VERSION_MAJOR) + "." + std::to_string(PETSC_VERSION_MINOR) + "." +
         std::to_string(PETSC_VERSION_SUBMINOR) + ", integers of " +
         std::to_string(8 * sizeof(PetscInt)) + " bits";
}

PetscSolution petsc_solve(const Ranks& ranks, const Layout& layout, const PartRows& rows,
                          std::span<const glm::dvec3> given, std::span<const glm::dvec3> ghosts,
                          std::int64_t used_total, const PetscSolveOptions& options) {
  agree(ranks, [&] {
    if (options.solver == Solver::ConjugateGradients)
      throw Error(ErrorCode::InvalidArgument,
                  "the solver cg is not available over ranks; take chebyshev or plain");
    if (!(options.tolerance > 0) || options.max_iterations < 0)
      throw Error(ErrorCode::InvalidArgument,
                  "a tolerance above 0 and a count of iterations from 0 are wanted");
  });
  return Iteration(ranks, layout, rows, options).run(given, ghosts, used_total);
}

}  // namespace planish
