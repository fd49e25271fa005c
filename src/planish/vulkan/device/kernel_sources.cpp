#include <algorithm>
#include <initializer_list>

#include "planish/vulkan/device/kernels.h"
#include "shaders/fair/shared_fair.h"
#include "shaders/kernel_code.h"
#include "shaders/shared.h"

namespace planish::vulkan {

namespace {

using enum Binding;

enum class KernelUse { Plain, Special };

KernelSource kernel_source(const char* name, std::span<const std::uint32_t> storage,
                           std::span<const std::uint32_t> texel, KernelUse use,
                           std::uint32_t parameter_bytes, std::initializer_list<Binding> bindings) {
  KernelSource source{name, storage, texel, use == KernelUse::Special, parameter_bytes, {}, 0};
  std::ranges::copy(bindings, source.bindings.begin());
  source.binding_count = static_cast<std::uint32_t>(bindings.size());
  return source;
}

#define PLANISH_TEXTS_Both(file) spirv::file, spirv::file##_texel
#define PLANISH_TEXTS_Once(file) spirv::file, spirv::file
#define PLANISH_KERNEL(texts, use, folder, file, name, parameters, ...)        \
  kernel_source("planish " #file, PLANISH_TEXTS_##texts(file), KernelUse::use, \
                sizeof(shared::parameters), {__VA_ARGS__}),

const KernelSource kSources[kKernelCount] = {
#include "planish/vulkan/device/kernels.inc"
};

#undef PLANISH_KERNEL
#undef PLANISH_TEXTS_Once
#undef PLANISH_TEXTS_Both

}  // namespace

const KernelSource& source_of(Kernel kernel) { return kSources[static_cast<std::size_t>(kernel)]; }

}  // namespace planish::vulkan
