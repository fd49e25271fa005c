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

  // The pieces of conjugate gradients, per coordinate, in the inner product
  // <x, y> = sum over rows of row_weight * x * y (row_weight is the valence).

  /// step = residual = initial residual, displacement = 0. Returns <residual, residual>.
  virtual glm::dvec3 cg_begin(std::span<const glm::dvec3> initial_residual,
                              std::span<const double> row_weights) = 0;
  /// image = B step. Returns <step, image>.
  virtual glm::dvec3 cg_apply() = 0;
  /// displacement += alpha * step; residual -= alpha * image. Returns <residual, residual> and
  /// the residual's norms.
  struct CgAdvance {
    glm::dvec3 residual_square;
    ErrorNorms error;
  };
  virtual CgAdvance cg_advance(const glm::dvec3& alpha) = 0;
  /// step = residual + beta * step.
  virtual void cg_turn(const glm::dvec3& beta) = 0;
};

/// Points held on a device, xyz.
class DevicePoints {
 public:
  virtual ~DevicePoints() = default;
  [[nodiscard]] virtual std::int32_t size() const = 0;
};

/// What `planish devices` and the report say of a device.
struct DeviceDescription {
  std::string kind;  ///< "cpu", "gpu" or "software" (a Vulkan device that runs on the CPU)
  std::string name, uuid, driver, api;
};

/// du x dv shorter than this times |du||dv| is no normal: the tangents are parallel up to rounding.
inline constexpr double kDegenerateNormal = 1e-6;

/// A device that applies stencil tables. Everything that returns has been carried out. Tables are
/// given in double; a backend that computes in float rounds weights once. Throws
/// Error{OutOfMemory} before taking memory that is not there, naming the limit, and
/// Error{DeviceLost}. A backend must outlive the solves and points it makes.
class Backend {
 public:
  virtual ~Backend() = default;

  [[nodiscard]] virtual DeviceDescription description() const = 0;

  /// Calls `work`, which uses parallel_for, on as many of the host's threads as the backend takes.
  virtual void run_on_host(const std::function<void()>& work) { work(); }

  /// `limit_masks` is B, square; it and the backend must outlive the solve, which the CPU may do
  /// from them where the device cannot.
  [[nodiscard]] virtual std::unique_ptr<Solve> make_solve(const SummedView& limit_masks) = 0;

  [[nodiscard]] virtual std::unique_ptr<DevicePoints> upload(
      std::span<const glm::dvec3> points) = 0;
  [[nodiscard]] virtual std::unique_ptr<DevicePoints> allocate(std::int32_t count) = 0;
  [[nodiscard]] virtual std::vector<glm::dvec3> download(const DevicePoints& points) = 0;

  /// target[first_target + i] = row i of `table` applied to `source`; source and target differ.
  virtual void apply(const StencilView<double>& table, const DevicePoints& source,
                     DevicePoints& target, std::int32_t first_target) = 0;

  /// Limit points and unit normals du x dv / |du x dv|, one per row, straight to the host. A
  /// normal whose |du x dv| < kDegenerateNormal |du||dv| is returned as zero: the caller replaces
  /// it.
  virtual void apply_limit(const StencilView<double>& table, const DevicePoints& source,
                           std::span<glm::dvec3> positions, std::span<glm::vec3> normals) = 0;

  /// Highest memory taken on the device so far; 0 where it is the host's.
  [[nodiscard]] virtual std::uint64_t peak_device_bytes() const = 0;
};

/// What the solve computes in. Surfaces are always evaluated in double.
enum class Precision { Float, Double };

struct CpuBackendOptions {
  Precision solve_precision = Precision::Double;
  int thread_count = 0;  ///< with the caller's; 0: those of his arena. Same bits for every count.
};

/// The backend of machines without a GPU, and the oracle that every shader is held against.
[[nodiscard]] std::unique_ptr<Backend> make_cpu_backend(const CpuBackendOptions& options = {});

}  // namespace planish
