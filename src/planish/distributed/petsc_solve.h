#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string>

#include "planish/distributed/part_rows.h"
#include "planish/solve/backend.h"
#include "planish/solve/progressive.h"

namespace planish {

/// PETSc, started and ended with this object; MPI must be running. It reads neither the command
/// line nor its own environment variable and files, and takes no signals.
class PetscSession {
 public:
  PetscSession();
  ~PetscSession();
  PetscSession(const PetscSession&) = delete;
  PetscSession& operator=(const PetscSession&) = delete;

  /// "3.18.5", and the bytes of its integers.
  [[nodiscard]] static std::string version();
};

struct PetscSolveOptions {
  Solver solver = Solver::Chebyshev;  ///< or Plain
  double tolerance = 1e-6;
  std::int32_t max_iterations = 200;
  std::int64_t block_vertices = kBlockVertices;
  std::function<void()> after_step;  ///< a sign of life
};

/// Of all ranks, but for the displacement, which is of owned vertices, and the peers. The mean
/// of `error` is rank 0's, those of the history are not taken (NaN), nor is `worst_vertex`.
struct PetscSolution : Interpolation {
  std::int64_t reductions = 0;  ///< over all ranks, for maxima
  std::int32_t peers = 0;       ///< ranks that this one gets ghosts from
};

/// Solves B (given + displacement) = given by the steps of interpolate() with its rule for their
/// end, on PETSc's vectors and halos; each step takes one maximum over all ranks. `given`: the
/// owned vertices in unit coordinates, `ghosts` those of rows.ghosts. The same bits for every rank
/// count. Throws AgreedError{InvalidArgument} for options out of range and conjugate gradients,
/// std::runtime_error where PETSc fails.
[[nodiscard]] PetscSolution petsc_solve(const Ranks& ranks, const Layout& layout,
                                        const PartRows& rows, std::span<const glm::dvec3> given,
                                        std::span<const glm::dvec3> ghosts, std::int64_t used_total,
                                        const PetscSolveOptions& options);

}  // namespace planish
