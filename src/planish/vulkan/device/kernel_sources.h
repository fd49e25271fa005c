#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "planish/vulkan/device/pipelines.h"

namespace planish::vulkan {

/// A kernel's SPIR-V, reading storage buffers or texel buffers, and what it is bound to.
struct KernelSource {
  std::span<const std::uint32_t> storage, texel;
  std::uint32_t parameter_bytes;
  std::array<Binding, kMaxBindings> bindings;
  std::uint32_t binding_count;
  bool on_demand = false;  ///< compiled by Pipelines::specialised() only
};

[[nodiscard]] const KernelSource& source_of(Kernel kernel);

}  // namespace planish::vulkan
