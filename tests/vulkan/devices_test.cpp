#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/solve/gpu_solve.h"
#include "support/calls.h"
#include "support/environment_variable.h"
#include "vulkan/device_cases.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

// Listing and picking devices; and that validation would speak up.

using ::testing::AllOf;
using ::testing::HasSubstr;

using VulkanDevices = VulkanTest;

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
  for (const std::string& wanted : {std::string(), std::to_string(list.best), best.name, best.uuid})
    EXPECT_EQ(make_backend({.device = wanted})->description().uuid, best.uuid) << wanted;
}

TEST_F(VulkanDevices, UnknownOnesAreRefusedWithAList) {
  const VulkanDeviceList list = list_vulkan_devices();
  for (const char* wanted : {"99", "no such device", "123456789012"})
    EXPECT_THAT(test::message_of(ErrorCode::NoDevice, [&] { make_backend({.device = wanted}); }),
                AllOf(HasSubstr(wanted), HasSubstr(list.devices[0].description.name)));
}

TEST(VulkanDevicesMissing, GiveAnEmptyListWithAReason) {
  const test::EnvironmentVariable files("VK_DRIVER_FILES", "/nonexistent.json");
  const test::EnvironmentVariable older_name("VK_ICD_FILENAMES", "/nonexistent.json");
  const VulkanDeviceList list = list_vulkan_devices();
  EXPECT_TRUE(list.devices.empty());
  EXPECT_EQ(list.best, -1);
  EXPECT_FALSE(list.reason.empty());
  EXPECT_NE(test::message_of(ErrorCode::NoDevice, [] { (void)make_vulkan_backend(); }), "no error");
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

// Records two commands that need a barrier between them, with or without it.
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

// A host's device, seen through a driver that pretends: memory that is not coherent, limits that
// are too low, a device that gets lost.

using namespace vulkan;

class HostDevices : public Embedding {
 protected:
  void SetUp() override {
    Embedding::SetUp();
    if (own_) host_ = own_->host_device();
  }
  Capabilities capabilities() {
    return query_capabilities(host_.get_instance_proc, host_.instance, host_.physical_device);
  }

  HostDevice host_;
};

TEST_F(HostDevices, FlushAndInvalidateMemoryThatIsNotCoherent) {
  PretendedDriver::pretence().split_memory = true;
  open();
  const Buffer buffer(*context_, 1000, MemoryUse::Device);
  std::vector<std::byte> sent(1000, std::byte{42}), received;
  submitter_->upload(whole(buffer), sent);
  EXPECT_EQ(PretendedDriver::count("vkFlushMappedMemoryRanges"), 1);
  EXPECT_EQ(PretendedDriver::count("vkInvalidateMappedMemoryRanges"), 0);
  submitter_->download(whole(buffer), [&](std::uint64_t, std::span<const std::byte> piece) {
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
    OwnDeviceOptions options = device_options();
    options.wanted = wanted;
    const OwnDevice device(options);
  };
  PretendedDriver::pretence().api_version = VK_API_VERSION_1_0;
  for (const std::string& wanted : {std::string(), std::string("0"), own_->capabilities().name})
    EXPECT_THAT(test::message_of(ErrorCode::NoDevice, [&] { picked(wanted); }),
                HasSubstr("offers Vulkan 1.0.0, 1.1 is needed"))
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
              HasSubstr("names several devices"));
}

TEST_F(HostDevices, HostsServeEveryAllocation) {
  HostBlocks blocks(host_, own_->capabilities().memory);
  host_.memory = blocks.hooks();
  host_.memory.allocate = [&](const MemoryRequest& request) {
    MemoryBlock block = blocks.allocate(request);
    block.size = request.requirements.size;
    return block;
  };
  {
    Context context(host_);
    const StencilTable masks = torus_masks(8, 8);
    const DeviceTable table(context, masks.view(), {.includes_own_rows = true});
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
  HostBlocks blocks(host_, own_->capabilities().memory);
  std::function<void(MemoryBlock&, const MemoryRequest&)> spoil;
  host_.memory = blocks.hooks();
  host_.memory.allocate = [&](const MemoryRequest& request) {
    MemoryBlock block = blocks.allocate(request);
    spoil(block, request);
    return block;
  };
  Context context(host_);
  const auto unmapped = [](MemoryBlock& block, const MemoryRequest&) { block.mapped = nullptr; };
  const auto beside = [](MemoryBlock& block, const MemoryRequest&) { block.offset = 2; };
  const auto small = [](MemoryBlock& block, const MemoryRequest& request) {
    block.size = request.requirements.size - 1;
  };
  const auto none = [&](MemoryBlock& block, const MemoryRequest&) {
    blocks.free(block);
    block = {};
  };
  struct Row {
    MemoryUse use;
    std::function<void(MemoryBlock&, const MemoryRequest&)> spoil;
    const char* words;
  };
  const Row rows[] = {
      {MemoryUse::Upload, unmapped,
       "MemoryHooks::allocate returned a block for Upload that is not mapped; set "
       "MemoryBlock::mapped"},
      {MemoryUse::Download, unmapped, "for Download"},
      {MemoryUse::Device, beside,
       "MemoryHooks::allocate returned a block for Device at MemoryBlock::offset 2, which is no "
       "multiple of "},
      {MemoryUse::Device, small, "bytes are needed; take MemoryRequest::requirements.size"},
      {MemoryUse::Device, none,
       "MemoryHooks::allocate returned a block for Device without memory; set "
       "MemoryBlock::memory, or throw Error{OutOfMemory} where there is none"}};
  for (const Row& row : rows) {
    spoil = row.spoil;
    expect_refusal(ErrorCode::InvalidArgument, row.words, [&] { Buffer(context, 1000, row.use); });
    EXPECT_EQ(blocks.living, 0) << row.words;
  }
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
  EXPECT_FALSE(capabilities().usable);
  EXPECT_THAT(capabilities().reason, HasSubstr("maxPerStageDescriptorStorageBuffers is 4"));
  EXPECT_THROW(Context{host_}, Error);
}

TEST_F(HostDevices, OfVulkan10AreRefused) {
  host_.api_version = VK_API_VERSION_1_0;
  expect_refusal(ErrorCode::NoDevice, "1.1", [&] { const Context context(host_); });
}

TEST_F(HostDevices, ThatAreNotGivenWholeAreRefused) {
  host_.device = VK_NULL_HANDLE;
  EXPECT_THROW(Context{host_}, Error);
}

TEST_F(HostDevices, MissingOptionalFeaturesAreNamed) {
  PretendedDriver::pretence().no_timestamps = true;
  EXPECT_TRUE(capabilities().usable);
  const std::vector<OptionalFeature> features = capabilities().optional_features;
  ASSERT_EQ(features.size(), 2u);
  EXPECT_EQ(features[0].name, "timestamps");
  EXPECT_FALSE(features[0].available);
  EXPECT_TRUE(features[1].available) << "VK_EXT_debug_utils";
}

TEST_F(HostDevices, LayersOverAnotherApiGetTheirExtension) {
  // The pretended driver refuses a device without VK_KHR_portability_subset, as its rule wants.
  PretendedDriver::pretence().portability_subset = true;
  const OwnDevice device(device_options());
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
  EXPECT_THAT(lines[0], HasSubstr(own_->capabilities().name));
}

TEST(VulkanResults, MapToErrorCodes) {
  const std::pair<VkResult, ErrorCode> codes[] = {
      {VK_ERROR_OUT_OF_DEVICE_MEMORY, ErrorCode::OutOfMemory},
      {VK_ERROR_DEVICE_LOST, ErrorCode::DeviceLost},
      {VK_ERROR_INCOMPATIBLE_DRIVER, ErrorCode::NoDevice}};
  for (const auto& [result, code] : codes)
    EXPECT_NE(test::message_of(code, [&] { check(result, "call"); }), "no error");
  for (const VkResult result : {VK_SUCCESS, VK_INCOMPLETE}) EXPECT_NO_THROW(check(result, "call"));
}

// What the kernels ask of a device, read from their SPIR-V: nothing beyond Vulkan 1.1 without any
// feature, within the limits that every device keeps. details.md of vulkan/ has the table.

// Numbers of the SPIR-V specification.
constexpr std::uint32_t kMagic = 0x07230203;
constexpr std::uint32_t kVersion13 = 0x00010300;  // Vulkan 1.1 takes no later one
enum Op : std::uint32_t {
  OpExtension = 10,
  OpExtInstImport = 11,
  OpEntryPoint = 15,
  OpExecutionMode = 16,
  OpCapability = 17,
  OpTypeInt = 21,
  OpTypeFloat = 22,
  OpTypeImage = 25,
  OpDecorate = 71,
  OpFSub = 131,
  OpFMul = 133,
};
constexpr std::uint32_t kShader = 1, kSampledBuffer = 46;                   // capabilities
constexpr std::uint32_t kCompute = 5;                                       // execution model
constexpr std::uint32_t kLocalSize = 17;                                    // execution mode
constexpr std::uint32_t kBuiltIn = 11, kBinding = 33, kNoContraction = 42;  // decorations
// Built-ins that do not depend on the size of subgroups.
const std::set<std::uint32_t> kPlainBuiltIns = {24, 25, 26, 27, 28, 29};
constexpr std::uint32_t kSmallestGroupLimit = 128;  // maxComputeWorkGroupInvocations of any device

struct Instruction {
  std::uint32_t op;
  std::vector<std::uint32_t> operands;
};

struct Module {
  std::uint32_t version = 0;
  std::vector<Instruction> instructions;
};

Module read_module(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::vector<std::uint32_t> words(bytes.size() / sizeof(std::uint32_t));
  std::memcpy(words.data(), bytes.data(), words.size() * sizeof words[0]);
  Module module;
  if (words.size() < 5 || words[0] != kMagic) return module;
  module.version = words[1];
  for (std::size_t at = 5; at < words.size();) {
    const std::size_t length = words[at] >> 16;
    if (length == 0 || at + length > words.size()) return {};
    module.instructions.push_back(
        {words[at] & 0xffff, {words.begin() + at + 1, words.begin() + at + length}});
    at += length;
  }
  return module;
}

std::map<std::string, Module> modules() {
  std::map<std::string, Module> all;
  for (const auto& entry : std::filesystem::directory_iterator(PLANISH_SHADER_FOLDER))
    if (entry.path().extension() == ".spv")
      all[entry.path().stem().string()] = read_module(entry.path());
  return all;
}

TEST(Spirv, EveryKernelIsThere) {
  const std::map<std::string, Module> all = modules();
  for (std::size_t i = 0; i < vulkan::kKernelCount; ++i) {
    // Debuggers are told "planish NAME".
    const std::string label = vulkan::source_of(static_cast<vulkan::Kernel>(i)).name;
    const std::string name = label.substr(label.find(' ') + 1);
    ASSERT_TRUE(all.count(name)) << name;
    EXPECT_GT(all.at(name).instructions.size(), 20u) << name;
  }
}

TEST(Spirv, KernelsNeedNoFeature) {
  for (const auto& [name, module] : modules()) {
    SCOPED_TRACE(name);
    EXPECT_LE(module.version, kVersion13);
    for (const Instruction& instruction : module.instructions) {
      const std::vector<std::uint32_t>& operands = instruction.operands;
      if (instruction.op == OpCapability) {
        // Neither subgroup operations nor 8, 16 or 64 bits, each of which has one of its own.
        EXPECT_TRUE(operands[0] == kShader || operands[0] == kSampledBuffer) << operands[0];
        if (operands[0] == kSampledBuffer) {
          EXPECT_TRUE(name.ends_with("_texel"));
        }
      }
      EXPECT_NE(instruction.op, OpExtension);
      if (instruction.op == OpEntryPoint) {
        EXPECT_EQ(operands[0], kCompute);
      }
      if (instruction.op == OpTypeInt || instruction.op == OpTypeFloat) {
        EXPECT_EQ(operands[1], 32u);
      }
    }
  }
}

TEST(Spirv, KernelsKeepToTheSmallestLimits) {
  for (const auto& [name, module] : modules()) {
    SCOPED_TRACE(name);
    std::set<std::uint32_t> bindings;
    std::uint32_t lanes = 0;
    for (const Instruction& instruction : module.instructions) {
      const std::vector<std::uint32_t>& operands = instruction.operands;
      if (instruction.op == OpExecutionMode && operands[1] == kLocalSize)
        lanes = operands[2] * operands[3] * operands[4];
      if (instruction.op != OpDecorate) continue;
      if (operands[1] == kBinding) bindings.insert(operands[2]);
      if (operands[1] == kBuiltIn) {
        EXPECT_TRUE(kPlainBuiltIns.count(operands[2])) << operands[2];
      }
    }
    EXPECT_GE(lanes, 1u);
    EXPECT_LE(lanes, kSmallestGroupLimit);
    EXPECT_LE(bindings.size(), vulkan::kMaxBindings);
  }
}

// A determinant that a device fuses with one of its products is not zero where the products are
// equal, but the rounding of the other: the fair kernels compare them with zero.
TEST(Spirv, FairKernelsNeverFuseDifferencesOfProducts) {
  int differences = 0;
  for (const auto& [name, module] : modules()) {
    if (!name.starts_with("fair_")) continue;
    std::set<std::uint32_t> exact, products;
    for (const Instruction& instruction : module.instructions) {
      const std::vector<std::uint32_t>& operands = instruction.operands;
      if (instruction.op == OpDecorate && operands[1] == kNoContraction) exact.insert(operands[0]);
      if (instruction.op == OpFMul) products.insert(operands[1]);
      if (instruction.op != OpFSub) continue;
      if (!products.count(operands[2]) || !products.count(operands[3])) continue;
      EXPECT_TRUE(exact.count(operands[1])) << name;
      ++differences;
    }
  }
  EXPECT_GT(differences, 20);
}

// Of VK_KHR_portability_subset all features are of images, samplers, events, vertex input and
// drawing: planish asks for no function that could use one.
TEST(Spirv, NoFunctionOfThePortabilitySubsetIsAskedFor) {
#define PLANISH_NAME(name) #name,
  const std::string_view asked[] = {PLANISH_VULKAN_DEVICE_FUNCTIONS(PLANISH_NAME)};
#undef PLANISH_NAME
  for (const std::string_view name : asked)
    for (const char* of : {"Image", "Sampler", "Event", "Graphics", "Draw", "RenderPass", "Vertex",
                           "Depth", "Stencil", "Blend"})
      EXPECT_EQ(name.find(of), std::string_view::npos) << name;
  EXPECT_GT(std::size(asked), 40u);
}

}  // namespace
}  // namespace planish::testing
