#include "planish/vulkan/device/context.h"

#include <algorithm>
#include <string>

#include "planish/core/error.h"
#include "planish/vulkan/device/own_device.h"

namespace planish::vulkan {

namespace {

// Devices with less than this would cut usual tables into many slices.
constexpr std::uint64_t kEnoughTexelElements = std::uint64_t(1) << 26;

PipelineVariant suitable_variant(const Capabilities& device) {
  const bool software =
      device.kind == "software" && device.max_texel_elements >= kEnoughTexelElements;
  return software ? kSoftwareVariant : kHardwareVariant;
}

Capabilities usable_capabilities(const HostDevice& host) {
  if (!host.get_instance_proc || !host.instance || !host.physical_device || !host.device)
    throw Error(ErrorCode::InvalidArgument,
                "a HostDevice needs get_instance_proc, instance, physical_device and device");
  if (static_cast<bool>(host.memory.allocate) != static_cast<bool>(host.memory.free))
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("HostDevice::memory has {}; set both, or neither",
                  host.memory.allocate ? "allocate, but no free" : "free, but no allocate"));
  if (host.api_version < VK_API_VERSION_1_1)
    throw Error(ErrorCode::NoDevice,
                "the host's instance or device is of Vulkan 1.0; planish needs 1.1");
  Capabilities capabilities =
      query_capabilities(host.get_instance_proc, host.instance, host.physical_device);
  if (!capabilities.usable)
    throw Error(ErrorCode::NoDevice, capabilities.name + " " + capabilities.reason);
  return capabilities;
}

template <class Number>
Number lowered(Number limit, Number option) {
  return option ? std::min(limit, option) : limit;
}

BindingLimit binding_limit_of(const Capabilities& device, const PipelineVariant& variant,
                              const ContextOptions& options) {
  BindingLimit limit{lowered(device.max_storage_range, options.max_storage_range)};
  const auto lower = [&](const BindingLimit& other) {
    if (other.bytes < limit.bytes) limit = other;
  };
  lower({device.max_allocation, "maxMemoryAllocationSize"});
  // Texels may be as small as a float; of larger ones there are fewer in as many bytes.
  if (variant.read_path == ReadPath::Texel)
    lower({device.max_texel_elements * sizeof(float), "4 * maxTexelBufferElements"});
  return limit;
}

DeviceFunctions load_functions(const HostDevice& host) {
  const InstanceFunctions functions =
      InstanceFunctions::load(host.get_instance_proc, host.instance);
  return DeviceFunctions::load(functions.vkGetDeviceProcAddr, host.device);
}

}  // namespace

Context::Context(const HostDevice& host, const ContextOptions& options)
    : device_(host.device),
      callbacks_(host.allocation_callbacks),
      capabilities_(usable_capabilities(host)),
      variant_(options.variant.value_or(suitable_variant(capabilities_))),
      binding_limit_(binding_limit_of(capabilities_, variant_, options)),
      max_group_count_(lowered(capabilities_.max_group_count, options.max_group_count)),
      further_usage_(options.further_usage),
      log_(host.log),
      functions_(load_functions(host)),
      labels_(host.features.debug_utils
                  ? DebugLabels(host.get_instance_proc, host.instance, host.device)
                  : DebugLabels()),
      memory_(functions_, device_, capabilities_, callbacks_, host.memory,
              (options.further_usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) != 0),
      pipelines_(functions_, device_, host.pipeline_cache, callbacks_, variant_, labels_) {
  log(formatted("planish: {}, {} buffers, {} bytes a binding", capabilities_.name,
                variant_.read_path == ReadPath::Texel ? "texel" : "storage", binding_limit_.bytes));
}

void Context::tell(std::string_view line) const noexcept {
  try {
    log(line);
  } catch (...) {
    return;
  }
}

Context::Context(const OwnDevice& own, const ContextOptions& options)
    : Context(own.host_device(), options) {}

}  // namespace planish::vulkan
