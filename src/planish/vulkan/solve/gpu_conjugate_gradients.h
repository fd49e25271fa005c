#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {

/// Vectors and recorded pieces of conjugate gradients on the device; the host computes alpha and
/// beta from sums() between them. Externally synchronised; the table outlives it.
class GpuConjugateGradients {
 public:
  /// `masks` was made with includes_own_rows. Throws Error{OutOfMemory} naming the limit.
  GpuConjugateGradients(Context& context, const DeviceTable& masks);

  /// displacement = image = 0, step = residual. residual() and weights() have been filled before.
  void record_begin(VkCommandBuffer commands) const noexcept;
  /// image = B step; sums() gets <step, image>.
  void record_apply(VkCommandBuffer commands) const noexcept;
  /// displacement += alpha step, residual -= alpha image; sums() gets <residual, residual>, the
  /// plain square sum and the largest square.
  void record_advance(VkCommandBuffer commands, const glm::vec3& alpha) const noexcept;
  /// step = residual + beta step.
  void record_turn(VkCommandBuffer commands, const glm::vec3& beta) const noexcept;

  [[nodiscard]] const Buffer& displacement() const { return displacement_; }
  [[nodiscard]] const Buffer& residual() const { return residual_; }
  [[nodiscard]] const Buffer& weights() const { return weights_; }
  /// shared::kSumFloats words.
  [[nodiscard]] const Buffer& sums() const { return sums_; }

 private:
  void bind(Context& context);
  /// Descriptor sets behind those of the masks' slices.
  enum BehindMasks : std::size_t { kAdvance, kTurn, kReduce };
  void record_rows(VkCommandBuffer commands, Kernel kernel, BehindMasks set,
                   const glm::vec3& factor) const noexcept;
  void record_reduce(VkCommandBuffer commands, std::uint32_t group_count) const noexcept;

  Context& context_;
  const DeviceTable& masks_;
  std::uint32_t row_groups_;  // of the kernels that walk vectors
  Buffer displacement_, step_, image_, residual_, weights_, partials_, sums_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
