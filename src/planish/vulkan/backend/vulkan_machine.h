#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planish/fair/fair_topology.h"
#include "planish/solve/backend.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/own_device.h"
#include "planish/vulkan/solve/gpu_solve.h"
#include "planish/vulkan/tables/device_table.h"
#include "planish/vulkan/vulkan_backend.h"

namespace planish::vulkan {

/// The command's device with all that works on it. Shared by a backend and what it hands out.
struct VulkanMachine {
  VulkanMachine(const OwnDeviceOptions& device_options, const ContextOptions& context_options)
      : device(device_options),
        context(device, context_options),
        submitter(context, device.queue(), device.capabilities().compute_family) {}

  OwnDevice device;
  Context context;
  Submitter submitter;

  /// Packs and uploads all slices of a new table.
  void upload_table(DeviceTable& table, const StencilView<double>& view);
  /// Points as shared::kPointFloats floats, rounded to nearest.
  void upload_points(const Buffer& target, std::span<const glm::dvec3> points);
  [[nodiscard]] std::vector<glm::dvec3> download_points(const Buffer& source, std::size_t count);
};

/// One that a backend with these options works on. Throws as make_vulkan_backend().
[[nodiscard]] std::shared_ptr<VulkanMachine> make_machine(const VulkanBackendOptions& options);

/// The backend on it.
[[nodiscard]] std::unique_ptr<Backend> make_backend(std::shared_ptr<VulkanMachine> machine);

/// The fair net of a topology in one submission, in float relative to the given points. Throws as
/// FairBuilder says.
[[nodiscard]] FairNet build_fair_net(VulkanMachine& machine, const FairTopology& topology,
                                     std::span<const glm::dvec3> given, const FairOptions& options);

/// planish::Solve on the command's own device: records with GpuSolve, submits, waits.
class VulkanSolve final : public planish::Solve {
 public:
  VulkanSolve(std::shared_ptr<VulkanMachine> machine, const StencilView<double>& limit_masks);

  void begin(std::span<const glm::dvec3> initial_residual) override;
  StepLog run(std::span<const StepCoefficients> steps, double stop_error) override;
  ErrorNorms error() override;
  [[nodiscard]] std::vector<glm::dvec3> displacement() const override;

 private:
  /// Runs the steps in one submission; at most max_steps(). Returns how many were taken.
  std::uint32_t run_piece(std::span<const StepCoefficients> steps, float stop_square,
                          std::vector<ErrorNorms>& errors);

  std::shared_ptr<VulkanMachine> machine_;
  DeviceTable masks_;
  GpuSolve solve_;
  Buffer report_;  // the host's copy of status and steps
  std::uint32_t side_ = 0;
};

}  // namespace planish::vulkan
