#include "planish/vulkan/backend/vulkan_solve.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "planish/core/assert.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/solve/stop_square.h"

namespace planish::vulkan {

namespace {

DeviceTable make_table(VulkanMachine& machine, const StencilView<double>& masks) {
  DeviceTableOptions options;
  options.includes_own_rows = true;
  DeviceTable table(machine.context, masks, options);
  machine.upload_table(table, masks);
  return table;
}

ErrorNorms norms_of(std::uint32_t max_square_bits, float square_sum, std::int32_t rows) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  ErrorNorms norms;
  norms.max = std::sqrt(static_cast<double>(std::bit_cast<float>(max_square_bits)));
  norms.rms = rows > 0 ? std::sqrt(static_cast<double>(square_sum) / rows) : 0;
  if (!std::isfinite(norms.max) || !std::isfinite(norms.rms)) norms.rms = kInfinity;
  return norms;
}

}  // namespace

VulkanSolve::VulkanSolve(std::shared_ptr<VulkanMachine> machine,
                         const StencilView<double>& limit_masks)
    : machine_(std::move(machine)),
      masks_(make_table(*machine_, limit_masks)),
      solve_(machine_->context, masks_),
      report_(machine_->context, solve_.status().size() + solve_.steps().size(),
              MemoryUse::Download) {
  PLANISH_ASSERT(limit_masks.source_count == limit_masks.row_count());
}

void VulkanSolve::begin(std::span<const glm::dvec3> initial_residual) {
  PLANISH_ASSERT(std::ssize(initial_residual) == masks_.row_count());
  machine_->upload_points(solve_.initial(), initial_residual);
  machine_->submitter.run([&](VkCommandBuffer commands) { solve_.record_clear(commands); });
  side_ = 0;
  in_gradients_ = false;
}

std::uint32_t VulkanSolve::run_piece(std::span<const StepCoefficients> steps, float stop_square,
                                     std::vector<ErrorNorms>& errors) {
  const auto count = static_cast<std::uint32_t>(steps.size());
  solve_.set_plan(steps);
  machine_->submitter.run([&](VkCommandBuffer commands) {
    solve_.record_steps(commands, {side_, count, stop_square});
    // Within the same submission: each wait costs the host as much as a small step.
    const VkBufferCopy status_copy{0, 0, solve_.status().size()};
    const VkBufferCopy steps_copy{0, solve_.status().size(), solve_.steps().size()};
    const DeviceFunctions& vk = machine_->context.vk();
    vk.vkCmdCopyBuffer(commands, solve_.status().handle(), report_.handle(), 1, &status_copy);
    vk.vkCmdCopyBuffer(commands, solve_.steps().handle(), report_.handle(), 1, &steps_copy);
  });
  report_.invalidate();
  shared::SolveStatus status;
  std::vector<shared::StepRecord> records(count);
  std::memcpy(&status, report_.mapped().data(), sizeof status);
  std::memcpy(records.data(), report_.mapped().data() + solve_.status().size(),
              count * sizeof(shared::StepRecord));
  const std::uint32_t measured =
      status.state == shared::kStateConverged ? status.iterations + 1 : status.iterations;
  for (std::uint32_t i = 0; i < measured; ++i)
    errors.push_back(
        norms_of(records[i].max_square_bits, records[i].square_sum, masks_.row_count()));
  side_ = status.side;
  return status.iterations;
}

StepLog VulkanSolve::run(std::span<const StepCoefficients> steps, double stop_error) {
  StepLog log;
  const float stop_square = stop_square_of(stop_error);
  while (!steps.empty()) {
    const std::span piece = steps.first(std::min<std::size_t>(steps.size(), solve_.max_steps()));
    const std::uint32_t taken = run_piece(piece, stop_square, log.errors);
    log.steps_taken += static_cast<std::int32_t>(taken);
    if (taken < piece.size()) break;
    steps = steps.subspan(piece.size());
  }
  return log;
}

ErrorNorms VulkanSolve::error() {
  if (in_gradients_)
    machine_->submitter.run([&](VkCommandBuffer commands) {
      const VkBufferCopy copy{0, 0, solve_.side(side_).size()};
      machine_->context.vk().vkCmdCopyBuffer(commands, gradients_->displacement().handle(),
                                             solve_.side(side_).handle(), 1, &copy);
    });
  // A step that goes nowhere still measures; what it writes is the side that the next one writes.
  const std::uint32_t side = side_;
  const StepCoefficients measure{0, 0};
  std::vector<ErrorNorms> errors;
  run_piece(std::span(&measure, 1), -1, errors);
  side_ = side;
  return errors.front();
}

std::vector<glm::dvec3> VulkanSolve::displacement() const {
  const Buffer& result = in_gradients_ ? gradients_->displacement() : solve_.side(side_);
  return machine_->download_points(result, masks_.row_count());
}

glm::dvec3 VulkanSolve::cg_begin(std::span<const glm::dvec3> initial_residual,
                                 std::span<const double> row_weights) {
  PLANISH_ASSERT(std::ssize(row_weights) == masks_.row_count());
  begin(initial_residual);
  if (!gradients_) gradients_.emplace(machine_->context, masks_);
  in_gradients_ = true;
  machine_->upload_points(gradients_->residual(), initial_residual);
  const std::vector<float> weights(row_weights.begin(), row_weights.end());
  machine_->submitter.upload({gradients_->weights().handle(), 0, weights.size() * sizeof(float)},
                             std::as_bytes(std::span(weights)));
  machine_->submitter.run([&](VkCommandBuffer commands) {
    gradients_->record_begin(commands);
    // An advance by nothing yields the sums.
    gradients_->record_advance(commands, glm::vec3(0));
  });
  return read_sums().residual_square;
}

glm::dvec3 VulkanSolve::cg_apply() {
  machine_->submitter.run([&](VkCommandBuffer commands) { gradients_->record_apply(commands); });
  return read_sums().residual_square;
}

planish::Solve::CgAdvance VulkanSolve::cg_advance(const glm::dvec3& alpha) {
  machine_->submitter.run(
      [&](VkCommandBuffer commands) { gradients_->record_advance(commands, glm::vec3(alpha)); });
  return read_sums();
}

void VulkanSolve::cg_turn(const glm::dvec3& beta) {
  machine_->submitter.run(
      [&](VkCommandBuffer commands) { gradients_->record_turn(commands, glm::vec3(beta)); });
}

planish::Solve::CgAdvance VulkanSolve::read_sums() {
  std::uint32_t sums[shared::kSumFloats];
  machine_->submitter.download(whole(gradients_->sums()),
                               [&](std::uint64_t, std::span<const std::byte> piece) {
                                 std::memcpy(sums, piece.data(), sizeof sums);
                               });
  CgAdvance result;
  for (int c = 0; c < 3; ++c) result.residual_square[c] = std::bit_cast<float>(sums[c]);
  result.error = norms_of(sums[4], std::bit_cast<float>(sums[3]), masks_.row_count());
  return result;
}

}  // namespace planish::vulkan
