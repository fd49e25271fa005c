#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "planish/vulkan/vulkan_backend.h"

namespace planish::test {

/// The device that tests take, as in vulkan::pick_device: PLANISH_TEST_DEVICE, or the best one.
[[nodiscard]] inline std::string wanted_device() {
  const char* wanted = std::getenv("PLANISH_TEST_DEVICE");
  return wanted ? wanted : "";
}

/// All of a SetUp(): a test without a Vulkan device is skipped, or fails where
/// PLANISH_REQUIRE_VULKAN=1.
inline void require_vulkan_device() {
  const VulkanDeviceList list = list_vulkan_devices();
  if (list.best >= 0) return;
  const char* required = std::getenv("PLANISH_REQUIRE_VULKAN");
  if (required && std::string(required) == "1") FAIL() << "no Vulkan device: " << list.reason;
  GTEST_SKIP() << "no Vulkan device: " << list.reason;
}

}  // namespace planish::test
