#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "planish/backend/backend.h"
#include "settings.h"

namespace planish::command {

/// A device that `--device` can name.
struct ListedDevice {
  std::string selector;  ///< "cpu" or the index
  DeviceDescription description;
  std::vector<std::pair<std::string, std::uint64_t>> limits;
  std::string unusable_because;  ///< empty: usable
};

/// Vulkan devices in their order, then the CPU.
[[nodiscard]] std::vector<ListedDevice> list_devices();

/// Position in `devices` of the one that `--device auto` takes for these settings.
[[nodiscard]] std::size_t automatic_choice(const std::vector<ListedDevice>& devices,
                                           const Settings& settings);

/// Why there are no Vulkan devices at all; empty when there are some.
[[nodiscard]] std::string why_no_vulkan(const std::vector<ListedDevice>& devices);

/// Position in `devices` of the one that `settings.device` names. Throws Error{NoDevice} naming
/// what there is; Error{InvalidArgument} for a precision that the device does not have.
[[nodiscard]] std::size_t choose_device(const std::vector<ListedDevice>& devices,
                                        const Settings& settings);

/// The backend of the chosen device. Throws Error{NoDevice}.
[[nodiscard]] std::unique_ptr<Backend> open_backend(const ListedDevice& device,
                                                    const Settings& settings);

}  // namespace planish::command
