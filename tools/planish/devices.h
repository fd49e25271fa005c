#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "options/settings.h"
#include "planish/backend/backend.h"

namespace planish::command {

/// A device that `--device` can name.
struct ListedDevice {
  std::string selector;  ///< "cpu", or the index among Vulkan devices
  DeviceDescription description;
  std::vector<std::pair<std::string, std::uint64_t>> limits;
  std::string unusable_because;  ///< empty: usable
  bool portability_subset = false;
  std::vector<std::string> missing;  ///< what it lacks that is not needed
};

struct DeviceList {
  std::vector<ListedDevice> devices;  ///< Vulkan devices in their order, then the CPU
  std::string no_vulkan_because;      ///< empty where a Vulkan device is usable
};

/// Asking Vulkan drivers takes a while. Least first.
enum class DeviceScope { CpuOnly, All };
[[nodiscard]] DeviceList list_devices(DeviceScope scope);

/// CpuOnly where the settings name the CPU, or leave the choice and nothing but the CPU can come
/// of it: no driver of hardware works without a device node of its kernel's, and a software
/// driver is not taken unasked.
[[nodiscard]] DeviceScope scope_of(const Settings& settings);

/// Position in `list.devices` of the one that `settings.device` names. "auto": hardware Vulkan
/// before the CPU, unless a precision or tolerance is wanted that only the CPU has. Throws
/// Error{NoDevice} naming what there is; Error{InvalidArgument} for a precision that the device
/// does not have.
[[nodiscard]] std::size_t choose_device(const DeviceList& list, const Settings& settings);

/// The backend of the chosen device. Throws Error{NoDevice}.
[[nodiscard]] std::unique_ptr<Backend> open_backend(const ListedDevice& device,
                                                    const Settings& settings);

}  // namespace planish::command
