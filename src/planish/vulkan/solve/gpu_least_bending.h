#pragma once

#include <array>
#include <cstdint>

#include "planish/vulkan/device/rounds.h"
#include "planish/vulkan/solve/bending_tables.h"
#include "planish/vulkan/tables/instances.h"

namespace planish::vulkan {

/// least_bending_moves() in a command buffer, of gathered points that it moves in place. Externally
/// synchronised; tables and points outlive it. Recording only records.
class GpuLeastBending {
 public:
  /// `points`: shared::kPointFloats floats per vertex, of one instance after another.
  /// Throws Error{OutOfMemory} naming the limit.
  GpuLeastBending(const Maker& on, const BendingTables& tables, const Buffer& points,
                  const Instances& instances = {});

  static constexpr std::uint32_t kRoundCount = 1 + 2 * kLeastBendingSteps;
  Wait record_round(VkCommandBuffer commands, std::uint32_t round) const noexcept;

 private:
  Context& context_;
  Instances instances_;
  shared::BendingParameters parameters_;
  std::uint32_t groups_;
  std::array<double, kLeastBendingSteps> momenta_;
  std::array<Pipeline, 3> pipelines_;
  Buffer directions_, base_, rows_, moves_, ahead_;  // a point per vertex
  DescriptorSets sets_;                              // of the three kernels
};

}  // namespace planish::vulkan
