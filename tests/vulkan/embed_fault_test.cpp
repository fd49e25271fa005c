// What hosts and drivers do wrong or lack: calls that fail, memory that is split, limits that are
// low.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <iostream>
#include <memory>

#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/device/driver.h"
#include "support/expect_error.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"
#include "vulkan/pretended_rules.h"
#include "vulkan/tables.h"

namespace planish::testing {
namespace {

using namespace vulkan;

class EmbedFaults : public Embedding {
 protected:
  /// Calls `make`, whose fallible calls fail one after another, until none does. Nothing must be
  /// left of a failed attempt, but for one kind that a Context keeps until its own end.
  void fail_each_call(const std::function<void()>& make, const std::string& kept = {}) {
    const auto alive = [&] {
      std::map<std::string, int> all = PretendedDriver::alive();
      all.erase(kept);
      return all;
    };
    const std::map<std::string, int> before = alive();
    int failures = 0;
    for (;; ++failures) {
      PretendedDriver::pretence().failing_call = PretendedDriver::fallible_calls() + failures + 1;
      const int last_call = PretendedDriver::pretence().failing_call;
      try {
        make();
        if (PretendedDriver::fallible_calls() < last_call) break;
        ADD_FAILURE() << "call " << failures + 1 << " failed and nobody said so";
      } catch (const Error& error) {
        EXPECT_TRUE(error.code() == ErrorCode::OutOfMemory || error.code() == ErrorCode::NoDevice)
            << error.what();
        EXPECT_THAT(error.what(), ::testing::HasSubstr("VK_ERROR_OUT_OF_DEVICE_MEMORY"));
      }
      ASSERT_EQ(alive(), before) << "after failure " << failures + 1;
      ASSERT_LT(failures, 2000);
    }
    PretendedDriver::pretence().failing_call = 0;
    std::cout << "  " << failures << " calls failed in turn\n";
    EXPECT_GT(failures, 0);
  }

  std::vector<Vertex> surface_of(const PolygonMesh& mesh, int level) {
    SystemOptions options;
    options.level = level;
    HostTopology topology(*context_, mesh, options, /*max_vertex_stride=*/24);
    topology.upload(*submitter_);
    slice_count_ = topology.device.slice_count();
    HostFrame frame(*context_, topology);
    return run(frame, mesh, iterations(30));
  }

  std::size_t slice_count_ = 0;
};

TEST_F(EmbedFaults, EveryFailingCallOfAnOwnDeviceUnwinds) {
  fail_each_call([&] { const OwnDevice device(device_options()); });
}

TEST_F(EmbedFaults, EveryFailingCallOfAContextUnwinds) {
  fail_each_call([&] { const Context context(*own_); });
}

TEST_F(EmbedFaults, EveryFailingCallOfAFrameUnwinds) {
  const PolygonMesh mesh = test::icosphere(1);
  const System system(mesh, {.levels = {1, 2}});
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant}) {
    ContextOptions options;
    options.variant = variant;
    open(options);
    fail_each_call(
        [&] {
          const DeviceSystem tables(*context_, system,
                                    {.answers_places = true, .takes_edits = true});
          const Buffer vertices(*context_, 1 << 20, MemoryUse::Device);
          SolveOptions solve;
          solve.vertices.buffer = vertices.handle();
          solve.instances = 3;
          solve.further_slots = {
              {.vertices = {vertices.handle()}, .moved = {vertices.handle(), 1 << 19, 9}}};
          solve.moved = {vertices.handle(), 1 << 19, 9};
          const vulkan::Solve frame(*context_, tables, solve);
          const Places places(*context_, tables, frame,
                              {.list = {.count = 9}, .results = {.buffer = vertices.handle()}});
          const Tessellation levels(*context_, tables, frame,
                                    {.vertices = {vertices.handle()}, .places = {3, 2}});
        },
        "Pipeline");
  }
}

TEST_F(EmbedFaults, EveryFailingCallOfTheCommandsMachineUnwinds) {
  const StencilTable masks = torus_masks(8, 8);
  const std::vector<glm::dvec3> initial = random_points(64);
  const auto machine = std::make_shared<VulkanMachine>(device_options(), ContextOptions{});
  const auto work = [&] {
    const Submitter submitter(machine->context, machine->device.queue(),
                              machine->device.capabilities().compute_family);
    VulkanSolve solve(machine, masks.view());
    solve.begin(initial);
    static_cast<void>(solve.run(std::vector<StepCoefficients>(3, {0, 1}), -1));
    static_cast<void>(solve.displacement());
  };
  work();  // the machine keeps its staging buffers
  fail_each_call(work);
}

TEST_F(EmbedFaults, ALostDeviceIsReportedAndLeavesNothing) {
  const StencilTable masks = torus_masks(8, 8);
  const std::map<std::string, int> before = PretendedDriver::alive();
  PretendedDriver::pretence().submit_result = VK_ERROR_DEVICE_LOST;
  try {
    const auto machine = std::make_shared<VulkanMachine>(device_options(), ContextOptions{});
    VulkanSolve solve(machine, masks.view());
    FAIL() << "nothing thrown";
  } catch (const VulkanError& error) {
    EXPECT_EQ(error.code(), ErrorCode::DeviceLost);
    EXPECT_EQ(error.result(), VK_ERROR_DEVICE_LOST);
  }
  EXPECT_EQ(PretendedDriver::alive(), before);
}

TEST_F(EmbedFaults, FourKibibyteRangesSliceWithEqualResults) {
  struct Case {
    PolygonMesh mesh;
    int level;
    std::uint32_t range;
  };
  // A level's points within one binding, more than one work group of rows: small meshes only.
  const Case cases[] = {{test::icosphere(0), 2, 4096},
                        {test::tetrahedron(), 3, 4096},
                        {test::torus(12, 7, 2, 0.7), 1, 8192}};
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant})
    for (const Case& one : cases) {
      ContextOptions options;
      options.variant = variant;
      open(options);
      const std::vector<Vertex> whole = surface_of(one.mesh, one.level);
      const std::size_t whole_slices = slice_count_;
      PretendedDriver::pretence().storage_range = one.range;
      open(options);
      EXPECT_EQ(context_->max_storage_range(), one.range);
      const std::vector<Vertex> sliced = surface_of(one.mesh, one.level);
      PretendedDriver::pretence().storage_range = 0;
      EXPECT_GT(slice_count_, whole_slices);
      ASSERT_EQ(sliced.size(), whole.size());
      for (std::size_t i = 0; i < whole.size(); ++i) {
        ASSERT_EQ(sliced[i].position, whole[i].position) << i;
        ASSERT_EQ(sliced[i].normal, whole[i].normal) << i;
      }
    }
}

// Every dispatch is looked at; llvmpipe's kernels do 16 chunks a work group. Vectors take more
// groups than there may be, whose lanes go on.
TEST_F(EmbedFaults, FewWorkGroupsSliceWithEqualResults) {
  const PolygonMesh meshes[] = {test::torus(40, 30, 2, 0.7),
                                test::with_random_creases(test::random_open_mesh(2), 0.1, 3)};
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant})
    for (const PolygonMesh& mesh : meshes) {
      ContextOptions options;
      options.variant = variant;
      open(options);
      const std::vector<Vertex> whole = surface_of(mesh, 2);
      const std::size_t whole_slices = slice_count_;
      const std::uint32_t few = variant.chunks_per_group > 1 ? 1 : 6;
      PretendedDriver::pretence().group_count = few;
      open(options);
      EXPECT_EQ(context_->max_group_count(), few);
      const std::vector<Vertex> sliced = surface_of(mesh, 2);
      PretendedDriver::pretence().group_count = 0;
      EXPECT_GT(slice_count_, whole_slices);
      ASSERT_EQ(sliced.size(), whole.size());
      EXPECT_EQ(std::memcmp(sliced.data(), whole.data(), whole.size() * sizeof whole[0]), 0);
    }
}

// Devices need not allow more than 4096 allocations, of all that a host has.
TEST_F(EmbedFaults, SmallBuffersShareAllocations) {
  const HostTopology topology(*context_, test::icosphere(1));
  const auto count = [](const char* kind) { return PretendedDriver::alive()[kind]; };
  const int memory = count("Memory"), buffers = count("Buffer");
  {
    std::vector<std::unique_ptr<vulkan::Solve>> solves;
    for (int i = 0; i < 40; ++i)
      solves.push_back(std::make_unique<vulkan::Solve>(*context_, topology.device));
    EXPECT_GT(count("Buffer"), buffers + 400);
    EXPECT_LE(count("Memory"), memory + 4);
    // In any order.
    std::swap(solves[0], solves[20]);
  }
  EXPECT_EQ(count("Buffer"), buffers);
  EXPECT_EQ(count("Memory"), memory);
}

// The rules themselves, by calls that break one each.
TEST(PretendedRules, SeeWhatBreaksThem) {
  RuleBook rules;
  const VkCommandBuffer commands = VK_NULL_HANDLE;
  VkBuffer buffer = (VkBuffer)1;
  VkBufferCreateInfo of_buffer{};
  of_buffer.size = 1024;
  rules.made(VkDevice(), static_cast<const VkBufferCreateInfo*>(&of_buffer),
             static_cast<const VkAllocationCallbacks*>(nullptr), &buffer);
  rules.set_limits({.group_count = 8, .storage_range = 512, .texel_elements = 16});
  VkWriteDescriptorSet write{};
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  const auto bind = [&](VkDeviceSize offset, VkDeviceSize range) {
    const VkDescriptorBufferInfo at{buffer, offset, range};
    write.pBufferInfo = &at;
    rules.look(VkDevice(), 1u, static_cast<const VkWriteDescriptorSet*>(&write), 0u,
               static_cast<const VkCopyDescriptorSet*>(nullptr));
  };
  const auto view = [&](VkDeviceSize offset, VkDeviceSize range) {
    VkBufferViewCreateInfo info{};
    info.buffer = buffer, info.format = VK_FORMAT_R32_UINT, info.offset = offset,
    info.range = range;
    rules.look(VkDevice(), static_cast<const VkBufferViewCreateInfo*>(&info),
               static_cast<const VkAllocationCallbacks*>(nullptr),
               static_cast<VkBufferView*>(nullptr));
  };
  const auto copy = [&](VkDeviceSize from, VkDeviceSize to, VkDeviceSize size) {
    const VkBufferCopy region{from, to, size};
    rules.look(commands, buffer, buffer, 1u, &region);
  };
  rules.look(commands, 8u, 1u, 1u);
  rules.look(commands, buffer, VkDeviceSize{1012});
  bind(512, 512);
  view(256, 64);
  copy(0, 512, 512);
  rules.look(commands, buffer, VkDeviceSize{1020}, VkDeviceSize{4}, 0u);
  EXPECT_TRUE(rules.broken().empty()) << *rules.broken().begin();
  std::size_t count = 0;
  const auto expect_one_more = [&] { EXPECT_EQ(rules.broken().size(), ++count); };
  rules.look(commands, 9u, 1u, 1u), expect_one_more();
  rules.look(commands, buffer, VkDeviceSize{1016}), expect_one_more();
  bind(0, 516), expect_one_more();
  bind(64, 256), expect_one_more();
  bind(768, 512), expect_one_more();
  view(0, 68), expect_one_more();
  view(64, 32), expect_one_more();
  copy(0, 256, 512), expect_one_more();
  copy(0, 768, 260), expect_one_more();
  rules.look(commands, buffer, VkDeviceSize{1020}, VkDeviceSize{8}, 0u), expect_one_more();
}

TEST_F(EmbedFaults, WhatNoSliceMeetsIsRefusedByName) {
  PretendedDriver::pretence().storage_range = 4096;
  open();
  try {
    static_cast<void>(surface_of(test::icosphere(2), 2));
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::OutOfMemory);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("maxStorageBufferRange is 4096"));
  }
}

// Of several limits that a binding has, the one that is met.
TEST_F(EmbedFaults, TexelsAreALimitOfBytesWhereTheyAreRead) {
  PretendedDriver::pretence().texel_elements = 65536;
  for (const bool texels : {true, false}) {
    open({.variant = texels ? kSoftwareVariant : kHardwareVariant});
    EXPECT_EQ(context_->max_storage_range() == 262144, texels);
    if (!texels) continue;
    EXPECT_NO_THROW((void)make_bindable(*context_, 262144, "words"));
    EXPECT_THAT(
        test::message_of(ErrorCode::OutOfMemory,
                         [&] { static_cast<void>(make_bindable(*context_, 262148, "words")); }),
        ::testing::HasSubstr("words take 262148 bytes of one binding, but 4 * "
                             "maxTexelBufferElements is 262144; use"));
  }
}

TEST_F(EmbedFaults, SplitMemoryThatIsNotCoherentServes) {
  const PolygonMesh mesh = test::icosphere(1);
  const std::vector<Vertex> expected = surface_of(mesh, 2);
  PretendedDriver::pretence().split_memory = true;
  open();
  const int flushes = PretendedDriver::count("vkFlushMappedMemoryRanges");
  const std::vector<Vertex> found = surface_of(mesh, 2);
  close();
  PretendedDriver::pretence().split_memory = false;
  EXPECT_GE(PretendedDriver::count("vkFlushMappedMemoryRanges"), flushes + 3);
  EXPECT_GT(PretendedDriver::count("vkInvalidateMappedMemoryRanges"), 0);
  EXPECT_EQ(PretendedDriver::illegal_maps(), 0);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    ASSERT_EQ(found[i].position, expected[i].position) << i;
}

TEST_F(EmbedFaults, SubgroupOperationsAreNotNeeded) {
  const PolygonMesh mesh = test::icosphere(1);
  const std::vector<Vertex> expected = surface_of(mesh, 1);
  PretendedDriver::pretence().no_subgroup_operations = true;
  open();
  EXPECT_EQ(own_->capabilities().subgroup_size, 1u);
  const std::vector<Vertex> found = surface_of(mesh, 1);
  for (std::size_t i = 0; i < found.size(); ++i)
    ASSERT_EQ(found[i].position, expected[i].position) << i;
}

}  // namespace
}  // namespace planish::testing
