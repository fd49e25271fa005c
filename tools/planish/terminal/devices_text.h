#pragma once

#include <string>

#include "devices.h"

namespace planish::command {

/// What `planish devices` says.
[[nodiscard]] std::string devices_table(const DeviceList& list);
/// The same as JSON, schema planish.devices/1.
[[nodiscard]] std::string devices_json(const DeviceList& list);

}  // namespace planish::command
