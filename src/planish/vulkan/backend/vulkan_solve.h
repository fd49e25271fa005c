#pragma once

#include <memory>
#include <optional>

#include "planish/backend/backend.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/solve/gpu_conjugate_gradients.h"
#include "planish/vulkan/solve/gpu_solve.h"

namespace planish::vulkan {

/// planish::Solve on the command's own device: records with GpuSolve, submits, waits.
class VulkanSolve final : public planish::Solve {
 public:
  VulkanSolve(std::shared_ptr<VulkanMachine> machine, const StencilView<double>& limit_masks);

  void begin(std::span<const glm::dvec3> initial_residual) override;
  StepLog run(std::span<const StepCoefficients> steps, double stop_error) override;
  ErrorNorms error() override;
  [[nodiscard]] std::vector<glm::dvec3> displacement() const override;

  glm::dvec3 cg_begin(std::span<const glm::dvec3> initial_residual,
                      std::span<const double> row_weights) override;
  glm::dvec3 cg_apply() override;
  CgAdvance cg_advance(const glm::dvec3& alpha) override;
  void cg_turn(const glm::dvec3& beta) override;

 private:
  /// Runs the steps in one submission; at most max_steps(). Returns how many were taken.
  std::uint32_t run_piece(std::span<const StepCoefficients> steps, float stop_square,
                          std::vector<ErrorNorms>& errors);
  [[nodiscard]] CgAdvance read_sums();

  std::shared_ptr<VulkanMachine> machine_;
  DeviceTable masks_;
  GpuSolve solve_;
  Buffer report_;                                   // the host's copy of status and steps
  std::optional<GpuConjugateGradients> gradients_;  // made by the first cg_begin
  bool in_gradients_ = false;                       // whose displacement is the current one
  std::uint32_t side_ = 0;
};

}  // namespace planish::vulkan
