#include "devices.h"

#include <algorithm>

#include "planish/core/error.h"
#include "planish/core/lower_case.h"
#include "planish/core/number_text.h"
#include "planish/core/visible_text.h"
#if PLANISH_HAS_VULKAN
#include "planish/vulkan/vulkan_backend.h"
#endif

namespace planish::command {
namespace {

bool is_vulkan(const ListedDevice& device) { return device.selector != "cpu"; }
bool is_usable(const ListedDevice& device) { return device.unusable_because.empty(); }
bool is_hardware(const ListedDevice& device) { return device.description.kind == "gpu"; }

std::string selectors(const std::vector<ListedDevice>& devices) {
  std::string text;
  for (const ListedDevice& device : devices) {
    text +=
        formatted("{}{} ({})", text.empty() ? "" : ", ", device.selector, device.description.name);
  }
  return text;
}

#if PLANISH_HAS_VULKAN
void add_vulkan_devices(DeviceList& list) {
  const VulkanDeviceList found = list_vulkan_devices();
  list.no_vulkan_because = found.reason;
  for (std::size_t i = 0; i < found.devices.size(); ++i) {
    const VulkanDeviceInfo& device = found.devices[i];
    list.devices.push_back({std::to_string(i),
                            device.description,
                            {{"memory_bytes", device.memory_bytes},
                             {"max_storage_bytes", device.max_storage_bytes},
                             {"max_allocation_bytes", device.max_allocation_bytes},
                             {"max_work_groups", device.max_work_groups},
                             {"max_storage_buffers", device.max_storage_buffers}},
                            device.usable ? "" : device.reason,
                            device.portability_subset,
                            device.missing});
  }
  if (!list.devices.empty() && std::ranges::none_of(list.devices, is_usable)) {
    const ListedDevice& first = list.devices.front();
    list.no_vulkan_because = first.description.name + " " + first.unusable_because;
  }
}
#else
void add_vulkan_devices(DeviceList& list) {
  list.no_vulkan_because = "this planish was built without Vulkan (PLANISH_VULKAN=OFF)";
}
#endif

// A number is an index: as a part of a name it would match what nobody meant.
std::size_t find_index(const std::vector<ListedDevice>& devices, const std::string& number) {
  const auto found = std::ranges::find(devices, number, &ListedDevice::selector);
  if (found != devices.end()) return static_cast<std::size_t>(found - devices.begin());
  throw Error(ErrorCode::NoDevice,
              formatted("--device {}: there {}{}", number, devices.size() == 1 ? "is " : "are ",
                        selectors(devices)));
}

// Exactly by index, UUID or name, else by a part of the name that only one device has; any case.
std::size_t find_named(const std::vector<ListedDevice>& devices, const std::string& name) {
  const std::string wanted = lower_case(name);
  std::int64_t index = 0;
  if (parse_integer(name, index)) return find_index(devices, name);
  std::vector<std::size_t> matches;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const DeviceDescription& description = devices[i].description;
    if (devices[i].selector == wanted || lower_case(description.uuid) == wanted ||
        lower_case(description.name) == wanted) {
      return i;
    }
    if (lower_case(description.name).find(wanted) != std::string::npos) matches.push_back(i);
  }
  if (matches.size() == 1) return matches.front();
  throw Error(ErrorCode::NoDevice, "--device " + visible(name) +
                                       (matches.empty() ? " names none of the devices: "
                                                        : " names several of the devices: ") +
                                       selectors(devices));
}

bool is_cpu(const Settings& settings) {
  return settings.device == "auto" || settings.device == "cpu";
}

}  // namespace

DeviceList list_devices(DeviceScope scope) {
  DeviceList list;
  if (scope == DeviceScope::All) add_vulkan_devices(list);
  list.devices.push_back({"cpu", make_cpu_backend()->description(), {}, ""});
  return list;
}

DeviceScope scope_of(const Settings& settings) {
  return is_cpu(settings) ? DeviceScope::CpuOnly : DeviceScope::All;
}

std::size_t best_vulkan(const DeviceList& list) {
  const std::vector<ListedDevice>& devices = list.devices;
  std::size_t best = devices.size();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (!is_vulkan(devices[i]) || !is_usable(devices[i])) continue;
    const bool better =
        best == devices.size() || (is_hardware(devices[i]) && !is_hardware(devices[best]));
    if (better) best = i;
  }
  return best;
}

std::size_t choose_device(const DeviceList& list, const Settings& settings) {
  const std::vector<ListedDevice>& devices = list.devices;
  if (is_cpu(settings)) return devices.size() - 1;
  std::size_t chosen = 0;
  if (settings.device == "vulkan") {
    chosen = best_vulkan(list);
    if (chosen == devices.size()) {
      throw Error(ErrorCode::NoDevice, "--device vulkan: " + list.no_vulkan_because);
    }
  } else {
    chosen = find_named(devices, settings.device);
  }
  const ListedDevice& device = devices[chosen];
  if (!is_usable(device)) {
    throw Error(ErrorCode::NoDevice, device.description.name + " " + device.unusable_because);
  }
  if (is_vulkan(device) && settings.precision != PrecisionChoice::Auto) {
    throw Error(ErrorCode::InvalidArgument,
                "--precision is for the CPU backend; leave it out with --device " +
                    settings.device + ", or take --device cpu");
  }
  return chosen;
}

std::unique_ptr<Backend> open_backend(const ListedDevice& device, const Settings& settings) {
#if PLANISH_HAS_VULKAN
  if (is_vulkan(device)) return make_vulkan_backend({.device = device.selector});
#endif
  (void)device;
  return make_cpu_backend({.solve_precision = solve_precision(settings)});
}

}  // namespace planish::command
