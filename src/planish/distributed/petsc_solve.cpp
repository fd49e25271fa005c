// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3.2, and
// Golub & Varga, "Chebyshev semi-iterative methods", 1961.
// The system is B d = r_0 with r_0 = V0 - B V0 taken from differences, as on one machine.
#include "planish/distributed/petsc_solve.h"

#include <petscmat.h>
#include <petscsf.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <limits>
#include <stdexcept>

#include "planish/core/error.h"
#include "planish/core/parallel.h"

namespace planish {

namespace {

constexpr std::size_t kGrain = 4096;

void require(PetscErrorCode code) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw std::runtime_error(
      formatted("PETSc: error {}, {}", code, text != nullptr ? text : "without a text"));
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
      : rows_(rows), ghosts_(3 * rows.ghosts.size()), sums_(3 * rows.sums.row_count()) {
    const std::int32_t owned = rows.row_count();
    for (std::int32_t row = 0; row < rows.sums.row_count(); ++row) all_sums_.push_back(row);
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
    multiply<Sources::Owned>(rows_, inner_, x, y);
    PetscCall(PetscSFBcastEnd(halo_, triple_, x, ghosts_.data(), MPI_REPLACE));
    multiply<Sources::Halo>(rows_.sums, all_sums_, x, sums_.data());
    multiply<Sources::All>(rows_, outer_, x, y);
    return 0;
  }

 private:
  enum class Sources { Owned, Halo, All };  // owned vertices; ghosts, too; and sums

  template <Sources kSources>
  [[nodiscard]] const double* source(std::int32_t column, const double* x) const {
    if (kSources == Sources::Owned || column < rows_.row_count())
      return x + 3 * static_cast<std::size_t>(column);
    if (kSources == Sources::Halo || column < rows_.first_sum())
      return ghosts_.data() + 3 * static_cast<std::size_t>(column - rows_.row_count());
    return sums_.data() + 3 * static_cast<std::size_t>(column - rows_.first_sum());
  }

  template <Sources kSources>
  void multiply(const RowEntries& rows, const std::vector<std::int32_t>& list, const double* x,
                double* y) const {
    parallel_each(list.size(), kGrain, [&](std::size_t i) {
      const std::int32_t row = list[i];
      double sum0 = 0, sum1 = 0, sum2 = 0;
      for (std::int64_t k = rows.offsets[row]; k < rows.offsets[row + 1]; ++k) {
        const double weight = rows.weights[k];
        const double* point = source<kSources>(rows.columns[k], x);
        sum0 += weight * point[0];
        sum1 += weight * point[1];
        sum2 += weight * point[2];
      }
      double* out = y + 3 * static_cast<std::size_t>(row);
      out[0] = sum0;
      out[1] = sum1;
      out[2] = sum2;
    });
  }

  const PartRows& rows_;
  Owned<PetscSF, PetscSFDestroy> halo_;
  Triple triple_;
  std::vector<double> ghosts_, sums_;
  std::vector<std::int32_t> inner_, outer_, all_sums_;
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
  const std::int32_t owned = rows.row_count(), first_sum = rows.first_sum();
  const auto point = [&](std::int32_t column) {
    return column < owned ? given[column] : ghosts[column - owned];
  };
  // About a point of each: far from the origin sums would lose digits.
  struct Sum {
    glm::dvec3 origin{}, sum{0.0};
    double weight = 0;
  };
  std::vector<Sum> sums(static_cast<std::size_t>(rows.sums.row_count()));
  for (std::size_t s = 0; s < sums.size(); ++s) {
    sums[s].origin = point(rows.sums.columns[rows.sums.offsets[s]]);
    for (std::int64_t k = rows.sums.offsets[s]; k < rows.sums.offsets[s + 1]; ++k) {
      sums[s].sum += rows.sums.weights[k] * (point(rows.sums.columns[k]) - sums[s].origin);
      sums[s].weight += rows.sums.weights[k];
    }
  }
  const auto way_from = [&](std::size_t row, std::int32_t column) {
    if (column < first_sum) return given[row] - point(column);
    const Sum& sum = sums[column - first_sum];
    return sum.weight * (given[row] - sum.origin) - sum.sum;
  };
  parallel_each(given.size(), kGrain, [&](std::size_t row) {
    glm::dvec3 sum(0.0);
    for (std::int64_t k = rows.offsets[row]; k < rows.offsets[row + 1]; ++k)
      sum += rows.weights[k] * way_from(row, rows.columns[k]);
    for (int c = 0; c < 3; ++c) out[3 * row + c] = sum[c];
  });
  require(VecRestoreArrayWrite(b, &out));
}

class RankSystem final : public StepSolve {
 public:
  RankSystem(const Ranks& ranks, const Layout& layout, const PartRows& rows,
             const PetscSolveOptions& options)
      : ranks_(ranks), rows_(rows), options_(options), kernel_(ranks, layout, rows) {
    const PetscInt own = 3 * static_cast<PetscInt>(rows.row_count());
    require(VecCreate(ranks.comm, &initial_));
    require(VecSetSizes(initial_, own, PETSC_DETERMINE));
    require(VecSetType(initial_, VECMPI));
    for (Vec* vector : {&displacement_, &step_, &residual_}) {
      require(VecDuplicate(initial_, vector));
      require(VecSet(*vector, 0));
    }
    require(
        MatCreateShell(ranks.comm, own, own, PETSC_DETERMINE, PETSC_DETERMINE, &kernel_, &shell_));
    require(
        MatShellSetOperation(shell_, MATOP_MULT, reinterpret_cast<void (*)(void)>(shell_multiply)));
  }

  /// The error of the initial residual.
  ErrorNorms begin(std::span<const glm::dvec3> given, std::span<const glm::dvec3> ghosts) {
    set_right_hand_side(initial_, rows_, given, ghosts);
    return measured(initial_);
  }

  StepLog run(std::span<const StepCoefficients> steps, double stop_error) override {
    StepLog log;
    for (const StepCoefficients& coefficients : steps) {
      log.errors.push_back(error());
      if (log.errors.back().max <= stop_error) break;
      require(VecAXPBY(step_, coefficients.gain, coefficients.momentum, residual_));
      require(VecAXPY(displacement_, 1.0, step_));
      ++log.steps_taken;
      if (options_.after_step) options_.after_step();
    }
    return log;
  }

  ErrorNorms error() override {
    require(MatMult(shell_, displacement_, residual_));
    require(VecAYPX(residual_, -1.0, initial_));
    return measured(residual_);
  }

  // Of the last residual measured; on rank 0. Added in the order of blocks, so that the sum has
  // the same bits for every rank count.
  [[nodiscard]] double root_mean_square(std::int64_t used_total) const {
    double sum = 0;
    for (const double piece : gather<double>(ranks_, block_sums_)) sum += piece;
    return used_total > 0 ? std::sqrt(sum / static_cast<double>(used_total)) : 0.0;
  }

  [[nodiscard]] std::vector<glm::dvec3> displacement() const {
    const double* values = nullptr;
    require(VecGetArrayRead(displacement_, &values));
    std::vector<glm::dvec3> result(static_cast<std::size_t>(rows_.row_count()));
    for (std::size_t v = 0; v < result.size(); ++v)
      result[v] = {values[3 * v], values[3 * v + 1], values[3 * v + 2]};
    require(VecRestoreArrayRead(displacement_, &values));
    return result;
  }

  [[nodiscard]] std::int64_t reductions() const { return reductions_; }
  [[nodiscard]] std::int32_t peers() const { return kernel_.peers(); }

 private:
  // One maximum over all ranks. Sums of squares, one a block, are kept for the end.
  ErrorNorms measured(Vec residual) {
    const double* values = nullptr;
    require(VecGetArrayRead(residual, &values));
    const auto rows = static_cast<std::int64_t>(rows_.row_count());
    const std::int64_t block = options_.block_vertices;
    block_sums_.assign(static_cast<std::size_t>((rows + block - 1) / block), 0.0);
    std::vector<double> largest(block_sums_.size(), 0.0);
    parallel_each(block_sums_.size(), 1, [&](std::size_t p) {
      const std::int64_t first = static_cast<std::int64_t>(p) * block;
      for (std::int64_t row = first; row < std::min(first + block, rows); ++row) {
        const double* v = values + 3 * row;
        double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        if (!std::isfinite(square)) square = std::numeric_limits<double>::infinity();
        block_sums_[p] += square;
        largest[p] = std::max(largest[p], square);
      }
    });
    require(VecRestoreArrayRead(residual, &values));
    const double most = largest.empty() ? 0.0 : std::ranges::max(largest);
    ++reductions_;
    return {std::sqrt(max_over(ranks_, most)), std::numeric_limits<double>::quiet_NaN()};
  }

  const Ranks& ranks_;
  const PartRows& rows_;
  const PetscSolveOptions& options_;
  Kernel kernel_;
  Owned<Vec, VecDestroy> initial_, displacement_, step_, residual_;
  Owned<Mat, MatDestroy> shell_;
  std::vector<double> block_sums_;  // of the last residual measured
  std::int64_t reductions_ = 0;
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
  return formatted("{}.{}.{}, integers of {} bits", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR,
                   PETSC_VERSION_SUBMINOR, 8 * sizeof(PetscInt));
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
  const InterpolationOptions steps{.solver = options.solver,
                                   .tolerance = options.tolerance,
                                   .max_iterations = options.max_iterations,
                                   .spectral_bound = rows.spectral_bound};
  RankSystem system(ranks, layout, rows, options);
  PetscSolution solution;
  solution.error = system.begin(given, ghosts);
  if (solution.error.max > options.tolerance) {
    take_steps(system, solution.error.max, steps, solution);
    solution.error = solution.history.back();
  } else {
    solution.history = {solution.error};
  }
  solution.error.rms = system.root_mean_square(used_total);
  conclude(steps, solution);
  solution.displacement = system.displacement();
  solution.reductions = system.reductions();
  solution.peers = system.peers();
  return solution;
}

}  // namespace planish
