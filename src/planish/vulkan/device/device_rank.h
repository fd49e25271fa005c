#pragma once

#include "planish/vulkan/device/driver.h"

namespace planish::vulkan {

/// Of several devices that of the highest rank is taken: discrete before integrated before virtual
/// before software. Negative: not usable.
[[nodiscard]] inline int rank_of(const Capabilities& device) {
  if (!device.usable) return -1;
  switch (device.type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return 2;
    case VK_PHYSICAL_DEVICE_TYPE_OTHER:
      return 1;
    default:
      return 0;
  }
}

}  // namespace planish::vulkan
