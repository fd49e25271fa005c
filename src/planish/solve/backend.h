#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planish/solve/stencil_table.h"

namespace planish {

/// One step of the interpolation: step <- momentum * step + gain * residual; then
/// displacement <- displacement + step, where residual = initial_residual - B displacement.
/// The plain iteration is {0, 1}.
struct StepCoefficients {
  double momentum;
  double gain;
};

/// Norms of the residual vectors' lengths over all vertices, in unit coordinates.
struct ErrorNorms {
  double max = 0;
  double rms = 0;
};

/// What run() did. errors[k] is the error before step k; steps_taken <= errors.size().
struct StepLog {
  std::int32_t steps_taken = 0;
  std::vector<ErrorNorms> errors;
};

/// The device measures residuals in its own precision; stopping this much below the tolerance
/// keeps the final check in double from failing by a rounding error.
inline constexpr double kStopMargin = 0.99;

/// What the iteration asks of the linear system B displacement = initial residual, wherever it is.
class StepSolve {
 public:
  virtual ~StepSolve() = default;

  /// Performs the steps in order without talking to the host in between. Before each step the
  /// error is measured; at the first error <= stop_error no further step is taken: that error is
  /// the last entry of the log, and begin() must come before any further step. Without such a
  /// stop, displacement and step carry on into the next call. A NaN residual counts as infinite.
  virtual StepLog run(std::span<const StepCoefficients> steps, double stop_error) = 0;

  /// The error of the current displacement.
  virtual ErrorNorms error() = 0;
};

/// That system on one device, with its work vectors. Externally synchronised.
class Solve : public StepSolve {
 public:
  /// Sets the right-hand side, one vector per row of B, and displacement = step = 0. Comes before
  /// the first run().
  virtual void begin(std::span<const glm::dvec3> initial_residual) = 0;

  [[nodiscard]] virtual std::vector<glm::dvec3> displacement() const = 0;
};

/// What `planish devices` and the report say of a device.
struct DeviceDescription {
  std::string kind;  ///< "cpu", "gpu" or "software" (a Vulkan device that runs on the CPU)
  std::string name, uuid, driver, api;
};

/// What a solve computes in. Where the CPU evaluates surfaces it does so in double.
enum class Precision { Float, Double };

/// A device that solves. Everything that returns has been carried out. Tables are given in double;
/// a backend that computes in float rounds weights once. Throws Error{OutOfMemory} before taking
/// memory that is not there, naming the limit, and Error{DeviceLost}. A backend must outlive the
/// solves it makes.
class Backend {
 public:
  virtual ~Backend() = default;

  [[nodiscard]] virtual DeviceDescription description() const = 0;

  /// Calls `work`, which uses parallel_for, on as many of the host's threads as the backend takes.
  virtual void run_on_host(const std::function<void()>& work) { work(); }

  /// Of what is solved on the host whatever the backend: conjugate gradients.
  [[nodiscard]] virtual Precision host_precision() const { return Precision::Double; }

  /// `limit_masks` is B, square; it and the backend must outlive the solve, which the CPU may do
  /// from them where the device cannot.
  [[nodiscard]] virtual std::unique_ptr<Solve> make_solve(const SummedView& limit_masks) = 0;

  /// Highest memory taken on the device so far; 0 where it is the host's.
  [[nodiscard]] virtual std::uint64_t peak_device_bytes() const = 0;
};

struct CpuBackendOptions {
  Precision solve_precision = Precision::Double;
  int thread_count = 0;  ///< with the caller's; 0: those of his arena. Same bits for every count.
};

/// The backend of machines without a GPU, and the oracle that every shader is held against.
[[nodiscard]] std::unique_ptr<Backend> make_cpu_backend(const CpuBackendOptions& options = {});

/// Conjugate gradients for B displacement = initial residual on the caller's threads, from
/// displacement 0, one by one until `goes_on`, which is given each step's error, says no; in the
/// inner product <x, y> = sum over rows of row_weight * x * y (row_weight is the valence), in which
/// B is to be self-adjoint. Returns the displacement. Same bits for every count of threads.
[[nodiscard]] std::vector<glm::dvec3> conjugate_gradients(
    Precision precision, const SummedView& limit_masks,
    std::span<const glm::dvec3> initial_residual, std::span<const double> row_weights,
    const std::function<bool(const ErrorNorms&)>& goes_on);

}  // namespace planish
