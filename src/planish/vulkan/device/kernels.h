#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "planish/vulkan/device/pipelines.h"

namespace planish::vulkan {

enum class Kernel : std::uint32_t {
#define PLANISH_KERNEL(texts, use, folder, file, name, ...) name,
#include "planish/vulkan/device/kernels.inc"
#undef PLANISH_KERNEL
};

#define PLANISH_KERNEL(...) +1
inline constexpr std::size_t kKernelCount = 0
#include "planish/vulkan/device/kernels.inc"
    ;
#undef PLANISH_KERNEL

/// Bindings of the kernel with the most of them.
inline constexpr std::uint32_t kMaxBindings = 8;

/// A kernel's SPIR-V, reading storage buffers or texel buffers, and what it is bound to.
struct KernelSource {
  const char* name;  ///< of its file, for debuggers
  std::span<const std::uint32_t> storage, texel;
  bool is_special;  ///< compiled by Pipelines::specialised() only
  std::uint32_t parameter_bytes;
  std::array<Binding, kMaxBindings> bindings;
  std::uint32_t binding_count;
};

[[nodiscard]] const KernelSource& source_of(Kernel kernel);

}  // namespace planish::vulkan
