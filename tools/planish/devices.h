#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "planish/job/job_settings.h"
#include "planish/solve/backend.h"

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

/// CpuOnly where the settings name the CPU or leave the choice.
[[nodiscard]] DeviceScope scope_of(const Settings& settings);

/// Position in `list.devices` of the one that "vulkan" names: the first usable Vulkan device,
/// hardware before software; the end of the list where there is none.
[[nodiscard]] std::size_t best_vulkan(const DeviceList& list);

/// Position in `list.devices` of the one that `settings.device` names. "auto" is the CPU: for files
/// it is faster than a GPU, whose tables the host has to make (tools/dev/bench/README.md). Throws
/// Error{NoDevice} naming what there is; Error{InvalidArgument} for a precision that the device
/// does not have.
[[nodiscard]] std::size_t choose_device(const DeviceList& list, const Settings& settings);

/// The backend of the chosen device. Throws Error{NoDevice}.
[[nodiscard]] std::unique_ptr<Backend> open_backend(const ListedDevice& device,
                                                    const Settings& settings);

/// What `planish devices` says.
[[nodiscard]] std::string devices_table(const DeviceList& list);
/// The same as JSON, schema planish.devices/1.
[[nodiscard]] std::string devices_json(const DeviceList& list);

}  // namespace planish::command
