// A host's device, seen through a vkGetInstanceProcAddr that pretends: memory that is not coherent,
// limits that are too low, a device that gets lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "planish/vulkan/gpu_solve.h"
#include "planish/vulkan/own_device.h"
#include "planish/vulkan/result.h"
#include "planish/vulkan/submitter.h"
#include "vulkan/fixture.h"
#include "vulkan/tables.h"

namespace planish::testing {
namespace {

using namespace vulkan;

/// What the pretending functions need, since Vulkan hands them no state of ours.
struct Pretence {
  PFN_vkGetInstanceProcAddr get_instance = nullptr;
  PFN_vkGetDeviceProcAddr get_device = nullptr;
  PFN_vkGetPhysicalDeviceMemoryProperties memory_properties = nullptr;
  PFN_vkGetPhysicalDeviceProperties2 properties = nullptr;
  PFN_vkFlushMappedMemoryRanges flush_ranges = nullptr;
  PFN_vkInvalidateMappedMemoryRanges invalidate_ranges = nullptr;
  std::uint32_t storage_buffers = 0;  // 0: as many as there are
  VkResult submit_result = VK_SUCCESS;
  int flushes = 0, invalidations = 0;
} pretence;

VKAPI_ATTR void VKAPI_CALL incoherent_memory(VkPhysicalDevice device,
                                             VkPhysicalDeviceMemoryProperties* properties) {
  pretence.memory_properties(device, properties);
  for (VkMemoryType& type : properties->memoryTypes)
    type.propertyFlags &= ~VkMemoryPropertyFlags(VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
}

VKAPI_ATTR void VKAPI_CALL few_buffers(VkPhysicalDevice device,
                                       VkPhysicalDeviceProperties2* properties) {
  pretence.properties(device, properties);
  if (pretence.storage_buffers)
    properties->properties.limits.maxPerStageDescriptorStorageBuffers = pretence.storage_buffers;
}

VKAPI_ATTR VkResult VKAPI_CALL count_flush(VkDevice device, std::uint32_t count,
                                           const VkMappedMemoryRange* ranges) {
  ++pretence.flushes;
  return pretence.flush_ranges(device, count, ranges);
}

VKAPI_ATTR VkResult VKAPI_CALL count_invalidation(VkDevice device, std::uint32_t count,
                                                  const VkMappedMemoryRange* ranges) {
  ++pretence.invalidations;
  return pretence.invalidate_ranges(device, count, ranges);
}

VKAPI_ATTR VkResult VKAPI_CALL failing_submit(VkQueue, std::uint32_t, const VkSubmitInfo*,
                                              VkFence) {
  return pretence.submit_result;
}

template <class Function>
PFN_vkVoidFunction instead_of(PFN_vkVoidFunction real, Function& kept, Function ours) {
  kept = reinterpret_cast<Function>(real);
  return reinterpret_cast<PFN_vkVoidFunction>(ours);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_device(VkDevice device, const char* name) {
  const PFN_vkVoidFunction real = pretence.get_device(device, name);
  if (!std::strcmp(name, "vkFlushMappedMemoryRanges"))
    return instead_of(real, pretence.flush_ranges, count_flush);
  if (!std::strcmp(name, "vkInvalidateMappedMemoryRanges"))
    return instead_of(real, pretence.invalidate_ranges, count_invalidation);
  if (!std::strcmp(name, "vkQueueSubmit") && pretence.submit_result != VK_SUCCESS)
    return reinterpret_cast<PFN_vkVoidFunction>(failing_submit);
  return real;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_instance(VkInstance instance, const char* name) {
  const PFN_vkVoidFunction real = pretence.get_instance(instance, name);
  if (!std::strcmp(name, "vkGetDeviceProcAddr"))
    return instead_of(real, pretence.get_device, get_device);
  if (!std::strcmp(name, "vkGetPhysicalDeviceMemoryProperties"))
    return instead_of(real, pretence.memory_properties, incoherent_memory);
  if (!std::strcmp(name, "vkGetPhysicalDeviceProperties2"))
    return instead_of(real, pretence.properties, few_buffers);
  return real;
}

class HostDevices : public VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    pretence = {};
    OwnDeviceOptions options;
    options.instance.validation = true;
    options.instance.message = [this](std::string_view message) {
      messages_.emplace_back(message);
    };
    own_ = std::make_unique<OwnDevice>(options);
    host_ = own_->host_device();
    pretence.get_instance = host_.get_instance_proc;
    host_.get_instance_proc = get_instance;
  }

  std::unique_ptr<OwnDevice> own_;
  HostDevice host_;
};

TEST_F(HostDevices, FlushAndInvalidateMemoryThatIsNotCoherent) {
  Context context(host_);
  Submitter submitter(context, own_->queue(), own_->capabilities().compute_family);
  const Buffer buffer(context, 1000, MemoryUse::Device);
  std::vector<std::byte> sent(1000, std::byte{42}), received;
  submitter.upload(whole(buffer), sent);
  EXPECT_EQ(pretence.flushes, 1);
  EXPECT_EQ(pretence.invalidations, 0);
  submitter.download(whole(buffer), [&](std::uint64_t, std::span<const std::byte> piece) {
    received.insert(received.end(), piece.begin(), piece.end());
  });
  EXPECT_EQ(pretence.invalidations, 1);
  EXPECT_EQ(received, sent);
}

TEST_F(HostDevices, HostsServeEveryAllocation) {
  const DeviceFunctions vk = DeviceFunctions::load(
      InstanceFunctions::load(host_.get_instance_proc, host_.instance).vkGetDeviceProcAddr,
      host_.device);
  int living = 0, made = 0;
  host_.memory.allocate = [&](const MemoryRequest& request) {
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.allocationSize = request.requirements.size;
    MemoryBlock block;
    check(vk.vkAllocateMemory(host_.device, &info, nullptr, &block.memory), "vkAllocateMemory");
    check(vk.vkMapMemory(host_.device, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped),
          "vkMapMemory");
    ++living, ++made;
    return block;
  };
  host_.memory.free = [&](const MemoryBlock& block) {
    vk.vkFreeMemory(host_.device, block.memory, nullptr);
    --living;
  };
  {
    Context context(host_);
    const StencilTable<double> masks = torus_masks(8, 8);
    DeviceTableOptions options;
    options.includes_own_rows = true;
    const DeviceTable table(context, masks.view(), nullptr, options);
    const GpuSolve solve(context, table);
    EXPECT_GE(made, 10);
    EXPECT_EQ(living, made);
  }
  EXPECT_EQ(living, 0);
}

TEST_F(HostDevices, TooFewStorageBuffersAreNamed) {
  pretence.storage_buffers = 4;
  const Capabilities capabilities =
      query_capabilities(host_.get_instance_proc, host_.instance, host_.physical_device);
  EXPECT_FALSE(capabilities.usable);
  EXPECT_THAT(capabilities.reason,
              ::testing::HasSubstr("maxPerStageDescriptorStorageBuffers is 4"));
  EXPECT_THROW(Context{host_}, Error);
}

TEST_F(HostDevices, ALostDeviceIsAnErrorWithItsName) {
  pretence.submit_result = VK_ERROR_DEVICE_LOST;
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
