// A host's device, seen through a driver that pretends: memory that is not coherent, limits that
// are too low, a device that gets lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <future>
#include <vector>

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/device/own_device.h"
#include "planish/vulkan/solve/gpu_solve.h"
#include "support/expect_error.h"
#include "vulkan/fixture.h"
#include "vulkan/pretended_driver.h"
#include "vulkan/pretended_memory.h"
#include "vulkan/tables.h"

namespace planish::testing {
namespace {

using namespace vulkan;

class HostDevices : public VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    PretendedDriver::reset();
    OwnDeviceOptions options;
    options.wanted = test::wanted_device();
    options.instance.get_proc = PretendedDriver::get_proc();
    options.instance.validation = validation_wanted();
    options.instance.message = [this](std::string_view message) {
      messages_.emplace_back(message);
    };
    own_ = std::make_unique<OwnDevice>(options);
    host_ = own_->host_device();
  }

  std::unique_ptr<OwnDevice> own_;
  HostDevice host_;
};

TEST_F(HostDevices, FlushAndInvalidateMemoryThatIsNotCoherent) {
  PretendedDriver::pretence().split_memory = true;
  Context context(host_);
  Submitter submitter(context, own_->queue(), own_->capabilities().compute_family);
  const Buffer buffer(context, 1000, MemoryUse::Device);
  std::vector<std::byte> sent(1000, std::byte{42}), received;
  submitter.upload(whole(buffer), sent);
  EXPECT_EQ(PretendedDriver::count("vkFlushMappedMemoryRanges"), 1);
  EXPECT_EQ(PretendedDriver::count("vkInvalidateMappedMemoryRanges"), 0);
  submitter.download(whole(buffer), [&](std::uint64_t, std::span<const std::byte> piece) {
    received.insert(received.end(), piece.begin(), piece.end());
  });
  EXPECT_EQ(PretendedDriver::count("vkInvalidateMappedMemoryRanges"), 1);
  EXPECT_EQ(received, sent);
}

TEST_F(HostDevices, FlushWholeAtomsOfAHostsBlocks) {
  PretendedDriver::pretence().split_memory = true;  // atoms of 256 bytes
  const DeviceFunctions vk = DeviceFunctions::load(
      InstanceFunctions::load(host_.get_instance_proc, host_.instance).vkGetDeviceProcAddr,
      host_.device);
  MemoryBlock block;
  host_.memory.allocate = [&](const MemoryRequest&) { return block; };
  host_.memory.free = [](const MemoryBlock&) {};
  {
    Context context(host_);  // asks what memory there is before any is taken
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.allocationSize = 8192;
    info.memoryTypeIndex = 1;
    check(vk.vkAllocateMemory(host_.device, &info, nullptr, &block.memory), "vkAllocateMemory");
    void* mapped = nullptr;
    check(vk.vkMapMemory(host_.device, block.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
    block.offset = 2048;
    block.mapped = static_cast<std::byte*>(mapped) + block.offset;
    block.coherent = false;
    for (const std::uint64_t bytes : {1u, 256u, 1000u}) {
      Buffer buffer(context, bytes, MemoryUse::Upload);
      buffer.flush();
      buffer.invalidate();
    }
  }
  vk.vkFreeMemory(host_.device, block.memory, nullptr);
  for (const auto& ranges : {PretendedDriver::flushed(), PretendedDriver::invalidated()}) {
    std::vector<VkDeviceSize> sizes;
    for (const VkMappedMemoryRange& range : ranges) {
      EXPECT_EQ(range.offset, block.offset);
      sizes.push_back(range.size);
    }
    EXPECT_THAT(sizes, ::testing::ElementsAre(256, 256, 1024));
  }
}

TEST_F(HostDevices, OfTooOldAnApiAreNotPicked) {
  const auto picked = [&](const std::string& wanted) {
    OwnDeviceOptions options;
    options.wanted = wanted;
    options.instance.get_proc = PretendedDriver::get_proc();
    const OwnDevice device(options);
  };
  PretendedDriver::pretence().api_version = VK_API_VERSION_1_0;
  for (const std::string& wanted : {std::string(), std::string("0"), own_->capabilities().name})
    EXPECT_THAT(test::message_of(ErrorCode::NoDevice, [&] { picked(wanted); }),
                ::testing::HasSubstr("offers Vulkan 1.0.0, 1.1 is needed"))
        << wanted;
}

TEST(PickDevice, PrefersWhatIsUsable) {
  std::vector<FoundDevice> devices(2);
  devices[0].capabilities.name = "an old GPU";
  devices[0].capabilities.type = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  devices[0].capabilities.reason = "is too old";
  devices[0].capabilities.usable = false;
  devices[1].capabilities.name = "a renderer";
  devices[1].capabilities.type = VK_PHYSICAL_DEVICE_TYPE_CPU;
  devices[1].capabilities.usable = true;
  EXPECT_EQ(pick_device(devices, ""), 1u);
  EXPECT_EQ(pick_device(devices, "1"), 1u);
  EXPECT_EQ(pick_device(devices, "Rend"), 1u);
  for (const char* wanted : {"0", "an old GPU", "old"})
    EXPECT_EQ(test::message_of(ErrorCode::NoDevice, [&] { (void)pick_device(devices, wanted); }),
              "device 'an old GPU' is too old");
  EXPECT_THAT(test::message_of(ErrorCode::NoDevice, [&] { (void)pick_device(devices, "a"); }),
              ::testing::HasSubstr("names several devices"));
}

/// A host's allocator of mapped memory, which counts.
struct CountedBlocks {
  CountedBlocks(const HostDevice& host, const VkPhysicalDeviceMemoryProperties& of)
      : device(host.device),
        memory(of),
        vk(DeviceFunctions::load(
            InstanceFunctions::load(host.get_instance_proc, host.instance).vkGetDeviceProcAddr,
            host.device)) {}
  MemoryBlock allocate(const MemoryRequest& request) {
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.allocationSize = request.requirements.size;
    info.memoryTypeIndex = mapped_type(memory, request.requirements.memoryTypeBits);
    MemoryBlock block;
    check(vk.vkAllocateMemory(device, &info, nullptr, &block.memory), "vkAllocateMemory");
    check(vk.vkMapMemory(device, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped), "vkMapMemory");
    ++living, ++made;
    return block;
  }
  void free(const MemoryBlock& block) {
    vk.vkFreeMemory(device, block.memory, nullptr);
    --living;
  }

  VkDevice device;
  VkPhysicalDeviceMemoryProperties memory;
  DeviceFunctions vk;
  int living = 0, made = 0;
};

TEST_F(HostDevices, HostsServeEveryAllocation) {
  CountedBlocks blocks(host_, own_->capabilities().memory);
  host_.memory.allocate = [&](const MemoryRequest& request) {
    MemoryBlock block = blocks.allocate(request);
    block.size = request.requirements.size;
    return block;
  };
  host_.memory.free = [&](const MemoryBlock& block) { blocks.free(block); };
  {
    Context context(host_);
    const StencilTable masks = torus_masks(8, 8);
    DeviceTableOptions options;
    options.includes_own_rows = true;
    const DeviceTable table(context, masks.view(), options);
    const GpuSolve solve(context, table);
    EXPECT_GE(blocks.made, 10);
    EXPECT_EQ(blocks.living, blocks.made);
  }
  EXPECT_EQ(blocks.living, 0);
}

TEST_F(HostDevices, HooksRunWithoutALock) {
  Context* planish = nullptr;
  std::vector<std::future<std::uint64_t>> others;  // end after the hook, whatever it finds
  bool was_free = false;
  host_.memory.allocate = [&](const MemoryRequest&) -> MemoryBlock {
    others.push_back(
        std::async(std::launch::async, [&] { return planish->memory().peak_bytes(); }));
    was_free = others.back().wait_for(std::chrono::seconds(20)) == std::future_status::ready;
    throw Error(ErrorCode::OutOfMemory, "no room");
  };
  host_.memory.free = [](const MemoryBlock&) {};
  Context context(host_);
  planish = &context;
  EXPECT_THROW(Buffer(context, 64, MemoryUse::Device), Error);
  EXPECT_TRUE(was_free);
}

TEST_F(HostDevices, BlocksThatCannotServeAreRefusedAndFreed) {
  CountedBlocks blocks(host_, own_->capabilities().memory);
  std::function<void(MemoryBlock&, const MemoryRequest&)> spoil;
  host_.memory.allocate = [&](const MemoryRequest& request) {
    MemoryBlock block = blocks.allocate(request);
    spoil(block, request);
    return block;
  };
  host_.memory.free = [&](const MemoryBlock& block) { blocks.free(block); };
  Context context(host_);
  const auto message_for = [&](MemoryUse use, const auto& how) {
    spoil = how;
    const std::string message =
        test::message_of(ErrorCode::InvalidArgument, [&] { Buffer(context, 1000, use); });
    EXPECT_EQ(blocks.living, 0) << message;
    return message;
  };
  const auto unmapped = [](MemoryBlock& block, const MemoryRequest&) { block.mapped = nullptr; };
  EXPECT_EQ(message_for(MemoryUse::Upload, unmapped),
            "MemoryHooks::allocate returned a block for Upload that is not mapped; set "
            "MemoryBlock::mapped");
  EXPECT_THAT(message_for(MemoryUse::Download, unmapped), ::testing::HasSubstr("for Download"));
  const auto beside = [](MemoryBlock& block, const MemoryRequest&) { block.offset = 2; };
  EXPECT_THAT(message_for(MemoryUse::Device, beside),
              ::testing::StartsWith("MemoryHooks::allocate returned a block for Device at "
                                    "MemoryBlock::offset 2, which is no multiple of "));
  const auto small = [](MemoryBlock& block, const MemoryRequest& request) {
    block.size = request.requirements.size - 1;
  };
  EXPECT_THAT(message_for(MemoryUse::Device, small),
              ::testing::EndsWith("bytes are needed; take MemoryRequest::requirements.size"));
  const auto none = [&](MemoryBlock& block, const MemoryRequest&) {
    blocks.free(block);
    block = {};
  };
  EXPECT_EQ(message_for(MemoryUse::Device, none),
            "MemoryHooks::allocate returned a block for Device without memory; set "
            "MemoryBlock::memory, or throw Error{OutOfMemory} where there is none");
}

TEST_F(HostDevices, HalfGivenHooksAreRefused) {
  const auto message = [&] {
    return test::message_of(ErrorCode::InvalidArgument, [&] { const Context context(host_); });
  };
  host_.memory = {[](const MemoryRequest&) { return MemoryBlock{}; }, nullptr};
  EXPECT_EQ(message(), "HostDevice::memory has allocate, but no free; set both, or neither");
  host_.memory = {nullptr, [](const MemoryBlock&) {}};
  EXPECT_EQ(message(), "HostDevice::memory has free, but no allocate; set both, or neither");
}

// OpenSubdiv's users bind a patch table's indices as index buffer.
TEST_F(HostDevices, BuffersCanBeDrawnFrom) {
  Context context(host_);
  const Buffer buffer(context, 64, MemoryUse::Device);
  const auto usages = PretendedDriver::notes().buffer_usages;
  ASSERT_EQ(usages.size(), 1u);
  for (const VkBufferUsageFlags usage :
       {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT})
    EXPECT_TRUE(*usages.begin() & usage);
}

TEST_F(HostDevices, TooFewStorageBuffersAreNamed) {
  PretendedDriver::pretence().storage_buffers = 4;
  const Capabilities capabilities =
      query_capabilities(host_.get_instance_proc, host_.instance, host_.physical_device);
  EXPECT_FALSE(capabilities.usable);
  EXPECT_THAT(capabilities.reason,
              ::testing::HasSubstr("maxPerStageDescriptorStorageBuffers is 4"));
  EXPECT_THROW(Context{host_}, Error);
}

TEST_F(HostDevices, ALostDeviceIsAnErrorWithItsName) {
  PretendedDriver::pretence().submit_result = VK_ERROR_DEVICE_LOST;
  Context context(host_);
  Submitter submitter(context, own_->queue(), own_->capabilities().compute_family);
  try {
    submitter.run([](VkCommandBuffer) {});
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::DeviceLost);
    EXPECT_STREQ(error.what(), "vkQueueSubmit: VK_ERROR_DEVICE_LOST");
  }
}

TEST_F(HostDevices, OfVulkan10AreRefused) {
  host_.api_version = VK_API_VERSION_1_0;
  try {
    const Context context(host_);
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::NoDevice);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("1.1"));
  }
}

TEST_F(HostDevices, ThatAreNotGivenWholeAreRefused) {
  host_.device = VK_NULL_HANDLE;
  EXPECT_THROW(Context{host_}, Error);
}

TEST_F(HostDevices, MissingOptionalFeaturesAreNamed) {
  PretendedDriver::pretence().no_timestamps = true;
  const Capabilities capabilities =
      query_capabilities(host_.get_instance_proc, host_.instance, host_.physical_device);
  EXPECT_TRUE(capabilities.usable);
  ASSERT_EQ(capabilities.optional_features.size(), 2u);
  EXPECT_EQ(capabilities.optional_features[0].name, "timestamps");
  EXPECT_FALSE(capabilities.optional_features[0].available);
  EXPECT_TRUE(capabilities.optional_features[1].available) << "VK_EXT_debug_utils";
}

TEST_F(HostDevices, LayersOverAnotherApiGetTheirExtension) {
  // The pretended driver refuses a device without VK_KHR_portability_subset, as its rule wants.
  PretendedDriver::pretence().portability_subset = true;
  OwnDeviceOptions options;
  options.wanted = test::wanted_device();
  options.instance.get_proc = PretendedDriver::get_proc();
  const OwnDevice device(options);
  EXPECT_TRUE(device.capabilities().portability_subset);
  EXPECT_THAT(device.capabilities().required_extensions,
              ::testing::ElementsAre("VK_KHR_portability_subset"));
  EXPECT_FALSE(own_->capabilities().portability_subset);
}

TEST_F(HostDevices, HearWhatWasChosen) {
  std::vector<std::string> lines;
  host_.log = [&](std::string_view line) { lines.emplace_back(line); };
  const Context context(host_);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_THAT(lines[0], ::testing::HasSubstr(own_->capabilities().name));
}

TEST(VulkanResults, MapToErrorCodes) {
  const auto code_of = [](VkResult result) {
    try {
      check(result, "call");
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::Cancelled;  // nothing thrown
  };
  EXPECT_EQ(code_of(VK_SUCCESS), ErrorCode::Cancelled);
  EXPECT_EQ(code_of(VK_INCOMPLETE), ErrorCode::Cancelled);
  EXPECT_EQ(code_of(VK_ERROR_OUT_OF_DEVICE_MEMORY), ErrorCode::OutOfMemory);
  EXPECT_EQ(code_of(VK_ERROR_DEVICE_LOST), ErrorCode::DeviceLost);
  EXPECT_EQ(code_of(VK_ERROR_INCOMPATIBLE_DRIVER), ErrorCode::NoDevice);
}

}  // namespace
}  // namespace planish::testing
