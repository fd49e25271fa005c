#include "devices.h"

#include <gmock/gmock.h>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "planish/core/error.h"

namespace planish::command {
namespace {

using test::ProcessResult;
using test::run_planish;
using testing::HasSubstr;

DeviceList list_of(const std::vector<std::string>& kinds) {
  DeviceList list;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const std::string number = std::to_string(i);
    list.devices.push_back(
        {number, {kinds[i], "Maker " + kinds[i] + " " + number, "AB-" + number}, {}, ""});
  }
  list.devices.push_back({"cpu", {"cpu", "8 threads"}, {}, ""});
  return list;
}

Settings for_device(const std::string& device) {
  Settings settings;
  settings.device = device;
  return settings;
}

std::size_t choose(const DeviceList& list, const std::string& device) {
  return choose_device(list, for_device(device));
}

TEST(Devices, AutoTakesTheCpu) {
  EXPECT_EQ(choose(list_of({"software", "gpu"}), "auto"), 2u);
  EXPECT_EQ(choose(list_of({}), "auto"), 0u);
}

TEST(Devices, VulkanTakesTheBestOfThem) {
  EXPECT_EQ(choose(list_of({"software", "gpu"}), "vulkan"), 1u);
  EXPECT_EQ(choose(list_of({"software"}), "vulkan"), 0u);
  DeviceList list = list_of({"software", "gpu"});
  list.devices[1].unusable_because = "has no compute queue";
  EXPECT_EQ(choose(list, "vulkan"), 0u);
}

TEST(Devices, AreNamedByIndexUuidNameOrPartOfIt) {
  const DeviceList list = list_of({"software", "gpu"});
  EXPECT_EQ(choose(list, "1"), 1u);
  EXPECT_EQ(choose(list, "ab-1"), 1u);
  EXPECT_EQ(choose(list, "maker GPU 1"), 1u);
  EXPECT_EQ(choose(list, "soft"), 0u);
  EXPECT_EQ(choose(list, "cpu"), 2u);
}

TEST(Devices, OnlyVulkanAsksDrivers) {
  EXPECT_EQ(scope_of(Settings{}), DeviceScope::CpuOnly);
  EXPECT_EQ(scope_of(for_device("cpu")), DeviceScope::CpuOnly);
  EXPECT_EQ(scope_of(for_device("vulkan")), DeviceScope::All);
  EXPECT_EQ(scope_of(for_device("0")), DeviceScope::All);
}

TEST(Devices, WhatCannotBeChosenSaysWhy) {
  DeviceList list = list_of({"software", "gpu"});
  const auto message_of = [&](const Settings& settings, ErrorCode code) -> std::string {
    try {
      (void)choose_device(list, settings);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code);
      return error.what();
    }
    return "nothing was thrown";
  };
  EXPECT_THAT(message_of(for_device("7"), ErrorCode::NoDevice), HasSubstr("Maker gpu 1"));
  EXPECT_THAT(message_of(for_device("maker"), ErrorCode::NoDevice), HasSubstr("several"));
  Settings with_precision = for_device("1");
  with_precision.precision = PrecisionChoice::Double;
  EXPECT_THAT(message_of(with_precision, ErrorCode::InvalidArgument), HasSubstr("--precision"));
  list.devices[1].unusable_because = "has no compute queue";
  EXPECT_THAT(message_of(for_device("1"), ErrorCode::NoDevice), HasSubstr("no compute queue"));
  list = list_of({});
  list.no_vulkan_because = "no Vulkan loader";
  EXPECT_THAT(message_of(for_device("vulkan"), ErrorCode::NoDevice), HasSubstr("no Vulkan loader"));
}

TEST(DevicesText, SaysWhatADeviceLacks) {
  DeviceList list = list_of({"gpu", "software"});
  list.devices[0].portability_subset = true;
  list.devices[0].missing = {"timestamps, with which recorded work can be timed on the device"};
  list.devices[1].unusable_because = "has no queue family with compute";
  const std::string text = devices_table(list);
  EXPECT_THAT(text, HasSubstr("0: a layer over another API (VK_KHR_portability_subset)\n"));
  EXPECT_THAT(text, HasSubstr("0: lacks timestamps, with which recorded work can be timed"));
  EXPECT_THAT(text, HasSubstr("unusable: has no queue family with compute"));
  EXPECT_THAT(text, testing::Not(HasSubstr("1: a layer")));
  EXPECT_THAT(text, HasSubstr("taken by vulkan"));
  const nlohmann::json json = nlohmann::json::parse(devices_json(list));
  EXPECT_EQ(json["vulkan"], "0");
  EXPECT_EQ(json["devices"][0]["portability_subset"], true);
  EXPECT_EQ(json["devices"][0]["missing"].size(), 1u);
  EXPECT_EQ(json["devices"][1]["portability_subset"], false);
  EXPECT_EQ(json["devices"][1]["unusable_because"], "has no queue family with compute");
}

TEST(DevicesCommand, ListsWhatAutoAndVulkanTake) {
  const ProcessResult text = run_planish({"devices"});
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_THAT(text.out, HasSubstr("taken by auto"));
  const nlohmann::json json = nlohmann::json::parse(run_planish({"devices", "--json"}).out);
  EXPECT_EQ(json["devices"].back()["selector"], "cpu");
  EXPECT_EQ(json["devices"].back()["usable"], true);
  EXPECT_EQ(json["auto"], "cpu");
}

class FitDevice : public test::FolderTest {
 protected:
  std::string cube_ = write("cube.obj", test::cube_obj());
};

TEST_F(FitDevice, AnUnknownDeviceExitsSix) {
  const ProcessResult result =
      run_planish({"fit", cube_, "-o", path("b.glb"), "--device", "Voodoo 2"});
  EXPECT_EQ(result.exit_code, 6);
  EXPECT_THAT(result.err, HasSubstr("--device Voodoo 2 names none of the devices"));
}

TEST_F(FitDevice, ANumberIsAnIndexAndNoPartOfAName) {
  const ProcessResult result = run_planish({"fit", cube_, "-o", path("b.glb"), "--device", "5"});
  EXPECT_EQ(result.exit_code, 6);
  EXPECT_THAT(result.err, HasSubstr("--device 5: there "));
  EXPECT_THAT(result.err, HasSubstr("cpu"));
  EXPECT_FALSE(exists("b.glb"));
}

// What ld.so says that the command loaded.
std::string loaded_by(const std::vector<std::string>& arguments) {
  test::PlanishProcess::Options options;
  options.environment = {"LD_DEBUG=files"};
  return run_planish(arguments, options).err;
}

TEST_F(FitDevice, NoDriverIsLoadedWhereNoneIsAskedFor) {
  using testing::Not;
  ASSERT_THAT(loaded_by({"inspect", cube_}), HasSubstr("libtbb"));  // the means work
  EXPECT_THAT(loaded_by({"inspect", cube_}), Not(HasSubstr("libvulkan")));
  EXPECT_THAT(loaded_by({"fit", "none.obj", "-o", path("b.glb")}), Not(HasSubstr("libvulkan")));
  EXPECT_THAT(loaded_by({"fit", cube_, "-o", path("b.glb"), "--device", "cpu"}),
              Not(HasSubstr("libvulkan")));
  EXPECT_THAT(loaded_by({"--help"}), Not(HasSubstr("libvulkan")));
}

TEST_F(FitDevice, WithoutADriverVulkanExitsSixWithTheReason) {
  // The loader finds its drivers through this variable; an empty list leaves none.
  test::PlanishProcess::Options options;
  options.environment = {"VK_ICD_FILENAMES=/nonexistent.json", "VK_DRIVER_FILES=/nonexistent.json"};
  const ProcessResult result =
      run_planish({"fit", cube_, "-o", path("b.glb"), "--device", "vulkan"}, options);
  EXPECT_EQ(result.exit_code, 6);
  EXPECT_THAT(result.err, HasSubstr("--device vulkan: "));
}

}  // namespace
}  // namespace planish::command
