#pragma once

#include <cstdint>

#include "planish/vulkan/evaluate/patch_tables.h"

namespace planish::vulkan {

/// The first step on the device: from given points and their displacement to the state of level 1
/// as GpuPatches reads it. Externally synchronised; tables and points outlive it.
class GpuFirstStep {
 public:
  /// `given`, `displacement`: shared::kPointFloats floats per vertex.
  GpuFirstStep(Context& context, const PatchTables& patches, const StepTables& tables,
               const Buffer& given, const Buffer& displacement);

  /// Only records, within kKernelScope; a barrier comes before the state is read.
  void record(VkCommandBuffer commands) const noexcept;

  /// shared::kPointFloats floats per point.
  [[nodiscard]] const Buffer& state() const { return state_; }

 private:
  struct Dispatch {
    Pipeline pipeline;
    shared::FirstStepParameters parameters;
    std::uint32_t groups;
  };

  Context& context_;
  Buffer state_;
  std::vector<Dispatch> dispatches_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
