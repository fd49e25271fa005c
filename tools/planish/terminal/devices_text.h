#pragma once

#include <cstddef>
#include <string>

#include "devices.h"

namespace planish::command {

/// What `planish devices` says; `automatic` is the place of the device that auto takes.
[[nodiscard]] std::string devices_table(const DeviceList& list, std::size_t automatic);
/// The same as JSON, schema planish.devices/1.
[[nodiscard]] std::string devices_json(const DeviceList& list, std::size_t automatic);

}  // namespace planish::command
