// Listing and picking devices; and that validation would speak up.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/own_device.h"
#include "support/environment_variable.h"
#include "vulkan/fixture.h"

namespace planish::testing {
namespace {

class VulkanDevices : public VulkanTest {};

TEST_F(VulkanDevices, ListSaysWhatEachIs) {
  const VulkanDeviceList list = list_vulkan_devices();
  ASSERT_FALSE(list.devices.empty());
  for (const VulkanDeviceInfo& device : list.devices) {
    EXPECT_FALSE(device.description.name.empty());
    EXPECT_FALSE(device.description.driver.empty());
    EXPECT_THAT(device.description.kind, ::testing::AnyOf("gpu", "software"));
    if (device.description.name.find("llvmpipe") != std::string::npos) {  // Mesa's, on the CPU
      EXPECT_EQ(device.description.kind, "software");
    }
    EXPECT_EQ(device.description.uuid.size(), 36u);
    EXPECT_EQ(device.usable, device.reason.empty());
    EXPECT_GE(device.max_storage_bytes, 1u << 27);
    EXPECT_GE(device.max_work_groups, 65535u);
  }
  EXPECT_TRUE(list.devices[list.best].usable);
}

TEST_F(VulkanDevices, AreTakenByIndexNameAndUuid) {
  const VulkanDeviceList list = list_vulkan_devices();
  const DeviceDescription& best = list.devices[list.best].description;
  for (const std::string& wanted :
       {std::string(), std::to_string(list.best), best.name, best.uuid}) {
    VulkanBackendOptions options;
    options.device = wanted;
    EXPECT_EQ(make_backend(options)->description().uuid, best.uuid) << wanted;
  }
}

TEST_F(VulkanDevices, UnknownOnesAreRefusedWithAList) {
  const VulkanDeviceList list = list_vulkan_devices();
  for (const char* wanted : {"99", "no such device", "123456789012"}) {
    VulkanBackendOptions options;
    options.device = wanted;
    try {
      static_cast<void>(make_backend(options));
      FAIL() << wanted;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::NoDevice);
      EXPECT_THAT(error.what(), ::testing::HasSubstr(wanted));
      EXPECT_THAT(error.what(), ::testing::HasSubstr(list.devices[0].description.name));
    }
  }
}

TEST(VulkanDevicesMissing, GiveAnEmptyListWithAReason) {
  const test::EnvironmentVariable files("VK_DRIVER_FILES", "/nonexistent.json");
  const test::EnvironmentVariable older_name("VK_ICD_FILENAMES", "/nonexistent.json");
  const VulkanDeviceList list = list_vulkan_devices();
  EXPECT_TRUE(list.devices.empty());
  EXPECT_EQ(list.best, -1);
  EXPECT_FALSE(list.reason.empty());
  try {
    static_cast<void>(make_vulkan_backend());
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::NoDevice);
  }
}

// Some drivers cannot be loaded again and again: a service that fits files one after another opens
// them hundreds of times.
TEST_F(VulkanDevices, CanBeListedAndOpenedAnyNumberOfTimes) {
  for (int i = 0; i < 60; ++i) {
    ASSERT_GE(list_vulkan_devices().best, 0) << i;
    if (i % 4 == 0) {
      ASSERT_NE(make_backend(), nullptr);
    }
  }
}

/// Records two commands that need a barrier between them, with or without it.
void overwrite_twice(vulkan::Context& context, vulkan::Submitter& submitter, bool with_barrier) {
  const vulkan::Buffer buffer(context, 1024, vulkan::MemoryUse::Device);
  submitter.run([&](VkCommandBuffer commands) {
    context.vk().vkCmdFillBuffer(commands, buffer.handle(), 0, VK_WHOLE_SIZE, 1);
    if (with_barrier)
      vulkan::record_barrier(context, commands, vulkan::kCopyScope, vulkan::kCopyScope);
    context.vk().vkCmdFillBuffer(commands, buffer.handle(), 0, VK_WHOLE_SIZE, 2);
  });
}

// A silent layer and an absent one look alike: this one must say something.
TEST_F(VulkanDevices, SynchronizationValidationIsOn) {
  if (!validation_wanted()) GTEST_SKIP() << "PLANISH_TEST_VALIDATION is 0";
  std::vector<std::string> heard;
  vulkan::OwnDeviceOptions options;
  options.instance.validation = true;
  options.instance.message = [&](std::string_view message) { heard.emplace_back(message); };
  const vulkan::OwnDevice device(options);
  vulkan::Context context(device.host_device());
  vulkan::Submitter submitter(context, device.queue(), device.capabilities().compute_family);
  overwrite_twice(context, submitter, /*with_barrier=*/true);
  EXPECT_THAT(heard, ::testing::IsEmpty());
  overwrite_twice(context, submitter, /*with_barrier=*/false);
  // SYNC-HAZARD-WRITE-AFTER-WRITE, or WRITE_AFTER_WRITE by newer layers.
  EXPECT_THAT(heard, ::testing::Contains(::testing::ContainsRegex("WRITE.AFTER.WRITE")));
}

}  // namespace
}  // namespace planish::testing
