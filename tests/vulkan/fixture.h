#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/device/own_device.h"
#include "planish/vulkan/vulkan_backend.h"
#include "support/environment_variable.h"
#include "support/vulkan_device.h"

namespace planish::testing {

/// Whether devices of tests are made with validation: PLANISH_TEST_VALIDATION=0 does without, where
/// the layer is missing or in the way.
[[nodiscard]] inline bool validation_wanted() {
  const char* wanted = std::getenv("PLANISH_TEST_VALIDATION");
  return !wanted || std::string(wanted) != "0";
}

/// Makes backends with validation and synchronization validation on; any message of theirs fails
/// the test. Without a device tests are skipped, or fail where PLANISH_REQUIRE_VULKAN=1.
class VulkanTest : public ::testing::Test {
 protected:
  void SetUp() override { test::require_vulkan_device(); }

  void TearDown() override {
    for (const std::string& message : messages_) ADD_FAILURE() << message;
  }

  std::shared_ptr<vulkan::VulkanMachine> make_machine(VulkanBackendOptions options = {}) {
    options.validation = validation_wanted();
    if (options.device.empty()) options.device = test::wanted_device();
    options.validation_message = device_options().instance.message;
    return vulkan::make_machine(options);
  }
  std::unique_ptr<Backend> make_backend(const VulkanBackendOptions& options = {}) {
    return vulkan::make_backend(make_machine(options));
  }

  /// Of devices that the tests make for themselves, by the loader's function or one that pretends.
  vulkan::OwnDeviceOptions device_options(PFN_vkGetInstanceProcAddr get_proc = nullptr) {
    vulkan::OwnDeviceOptions options;
    options.wanted = test::wanted_device();
    options.instance.get_proc = get_proc;
    options.instance.validation = validation_wanted();
    options.instance.message = [this](std::string_view message) {
      const std::lock_guard lock(mutex_);
      messages_.emplace_back(message);
    };
    return options;
  }

  // Hazards between submissions are looked for only when the environment says so.
  test::EnvironmentVariable layer_enables_{
      "VK_LAYER_ENABLES",
      "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT:"
      "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT"};
  std::mutex mutex_;
  std::vector<std::string> messages_;
};

}  // namespace planish::testing
