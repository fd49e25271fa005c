#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <numbers>
#include <optional>

#include "fair/fair_case.h"
#include "planish/surface/evaluate.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/device/driver.h"
#include "support/calls.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/apply_table.h"
#include "vulkan/device_cases.h"
#include "vulkan/embedding_fixture.h"
#include "vulkan/pretended_driver.h"

namespace planish::testing {
namespace {

// Drivers that differ: every kernel of a frame, of both methods, gives the same bits on each.

using namespace vulkan;

// All that a driver gave.
struct Bytes {
  template <class Items>
  void add(const Items& items) {
    const auto more = std::as_bytes(std::span(items));
    all.insert(all.end(), more.begin(), more.end());
  }
  std::vector<std::byte> all;
};

class EmbedDrivers : public Embedding {
 protected:
  /// Vertices and status of frames of both methods, one by one, beside each other and as instances,
  /// and places on a surface.
  void add_frames(Bytes& bytes) {
    const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
    const HostTopology first = topology_of(mesh, {.level = 1}),
                       second =
                           topology_of(mesh, {.level = 1, .method = InterpolationMethod::Fair});
    HostFrame one = frame_of(first), other = frame_of(second), crowd = frame_of(first, {}, 3);
    for (const int pose : {0, 1}) {
      one.set_points(posed(mesh, pose));
      other.set_points(posed(mesh, pose));
      for (std::uint32_t i = 0; i < 3; ++i)
        crowd.set_points(posed(mesh, pose + static_cast<int>(i)), i);
      submitter_->run([&](VkCommandBuffer commands) {
        crowd.record(commands, stopping(20, 1e-4));
        if (pose == 0) {
          one.record(commands, stopping(20, 1e-4));
          other.record(commands, {});
          return;
        }
        const SolveCall solves[] = {{&one.solve, iterations(9)}, {&other.solve, {}}};
        const EvaluateCall evaluations[] = {{&one.solve, {}}, {&other.solve, {}}};
        record_solves(commands, solves);
        record_evaluates(commands, evaluations);
        one.solve.record_status(commands, one.report.handle(), 0);
        other.solve.record_status(commands, other.report.handle(), 0);
      });
      for (const auto& [frame, instance] :
           {std::pair{&one, 0u}, {&other, 0u}, {&crowd, 0u}, {&crowd, 1u}, {&crowd, 2u}}) {
        bytes.add(frame->vertices(instance));
        bytes.add(bits_of(frame->status(instance)));
      }
    }
    // Of few kinds of corners: the weights of each take 55 kB, and tables may be a megabyte at
    // most.
    add_places(bytes, test::icosphere(1));
    add_large_rings(bytes, InterpolationMethod::Progressive, 3);
    add_large_rings(bytes, InterpolationMethod::Fair, 1);
  }

  void add_large_rings(Bytes& bytes, InterpolationMethod method, std::uint32_t instances) {
    const PolygonMesh mesh = hub_of(40, 3, 2 * std::numbers::pi);
    const HostTopology topology = topology_of(mesh, {.level = 1, .method = method});
    HostFrame frame = frame_of(topology, {}, instances);
    for (std::uint32_t i = 0; i < instances; ++i)
      frame.set_points(posed(mesh, static_cast<int>(i)), i);
    submitter_->run([&](VkCommandBuffer commands) { frame.record(commands, iterations(9)); });
    for (std::uint32_t i = 0; i < instances; ++i) bytes.add(frame.vertices(i));
  }

  /// Position, normal and derivatives at places all over a solved surface.
  void add_places(Bytes& bytes, const PolygonMesh& mesh) {
    const System system(mesh);
    const DeviceSystem tables(*context_, system, {.answers_places = true});
    upload_tables(*context_, *submitter_, system, tables);
    const Buffer points = filled(*context_, points_of(mesh));
    std::vector<PlaceRecord> records;
    for (std::uint32_t face = 0; face < static_cast<std::uint32_t>(mesh.face_count()); ++face)
      for (const float at : {0.0f, 0.2f, 0.49f}) records.push_back({face, at, 0.5f * at});
    const Buffer list = filled(*context_, records);
    const auto count = static_cast<std::uint32_t>(records.size());
    Buffer results(*context_, sizeof(PlaceResult) * count, MemoryUse::Download);
    const vulkan::Solve solve(*context_, tables, {.given = {points.handle()}});
    const Places asked(*context_, tables, solve,
                       {{list.handle(), 0, 12, count}, {.buffer = results.handle()}});
    submitter_->run([&](VkCommandBuffer commands) {
      solve.record_solve(commands, iterations(5));
      solve.record_surface(commands);
      asked.record_evaluate(commands);
    });
    bytes.add(fetched<PlaceResult>(results, count));
  }

  /// What the command's machine makes: steps and stencils.
  void add_backend(Bytes& bytes, const ContextOptions& options) {
    const auto machine = std::make_shared<VulkanMachine>(device_options(), options);
    const StencilTable masks = torus_masks(30, 20);
    const std::vector<glm::dvec3> given = random_points(600);
    VulkanSolve solve(machine, masks.view());
    solve.begin(given);
    for (const ErrorNorms& error :
         solve.run(std::vector<StepCoefficients>(5, {0.2, 1.1}), -1).errors)
      bytes.add(std::array{error.max, error.rms});
    bytes.add(solve.displacement());
    bytes.add(applied(*machine, random_table(500, 600), given, std::vector<glm::dvec3>(510), 10));
  }

  std::vector<std::byte> bytes_of(const ContextOptions& options,
                                  const std::function<void(const Capabilities&)>& check) {
    Bytes bytes;
    add_backend(bytes, options);
    open(options);
    check(own_->capabilities());
    add_frames(bytes);
    close();
    return bytes.all;
  }

  /// The same on the driver as it is and on one that differs, reading both ways.
  void expect_equal_bytes(
      const std::function<void(PretendedDriver::Pretence&)>& differ,
      const std::function<void(const Capabilities&)>& check = [](const Capabilities&) {}) {
    // Of the driver as it is; made once a process, since kernels compile anew with every context.
    static std::vector<std::byte> made[2];
    for (const bool hardware : {false, true}) {
      const ContextOptions options{.variant = hardware ? kHardwareVariant : kSoftwareVariant};
      std::vector<std::byte>& expected = made[hardware ? 1 : 0];
      if (expected.empty()) expected = bytes_of(options, [](const Capabilities&) {});
      differ(PretendedDriver::pretence());
      const std::vector<std::byte> found = bytes_of(options, check);
      PretendedDriver::pretence() = {};
      EXPECT_GT(expected.size(), 1000u);
      EXPECT_EQ(found, expected);
    }
    EXPECT_EQ(PretendedDriver::illegal_maps(), 0);
  }
};

TEST_F(EmbedDrivers, SubgroupsOfAnySize) {
  for (const std::uint32_t size : {1u, 32u, 64u, 128u})
    expect_equal_bytes([&](auto& pretence) { pretence.subgroup_size = size; },
                       [&](const auto& told) { EXPECT_EQ(told.subgroup_size, size); });
}

TEST_F(EmbedDrivers, WhatTheyLackChangesNothing) {
  using Pretence = PretendedDriver::Pretence;
  struct Row {
    const char* name;
    void (*differ)(Pretence&);
    bool (*is_told)(const Capabilities&);
  };
  const auto any = [](const Capabilities&) { return true; };
  const Row rows[] = {
      {"no subgroup operations", [](Pretence& p) { p.no_subgroup_operations = true; },
       [](const Capabilities& told) { return told.subgroup_size == 1; }},
      // As of a discrete GPU: a heap of its own, one that the host sees too, too small for an
      // upload, and the host's, smaller than what the device's holds.
      {"a small heap that device and host see",
       [](Pretence& p) { p.bar_bytes = 4096, p.host_bytes = 1u << 20; }, any},
      {"ranges of 128 MiB and as few texels as any device has",
       [](Pretence& p) { p.storage_range = 128u << 20, p.texel_elements = 65536; },
       [](const Capabilities& told) { return told.max_storage_range == 128u << 20; }},
      {"no timestamps", [](Pretence& p) { p.no_timestamps = true; },
       [](const Capabilities& told) { return told.timestamp_bits == 0; }},
      {"a portability subset", [](Pretence& p) { p.portability_subset = true; }, any}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    expect_equal_bytes(row.differ,
                       [&](const Capabilities& told) { EXPECT_TRUE(row.is_told(told)); });
  }
}

TEST_F(EmbedDrivers, MemoryThatIsNotCoherent) {
  expect_equal_bytes([](auto& pretence) { pretence.split_memory = true; });
  EXPECT_GT(PretendedDriver::count("vkFlushMappedMemoryRanges"), 4);
  EXPECT_GT(PretendedDriver::count("vkInvalidateMappedMemoryRanges"), 4);
}

TEST_F(EmbedDrivers, AHeapThatIsFullIsNamedWithItsOwnBytes) {
  PretendedDriver::pretence().bar_bytes = 4096;
  PretendedDriver::pretence().host_bytes = 8192;
  open();
  const Buffer small(*context_, 8000, MemoryUse::Upload);
  const Buffer on_device(*context_, 1u << 20, MemoryUse::Device);
  EXPECT_THAT(test::message_of(ErrorCode::OutOfMemory,
                               [&] { const Buffer more(*context_, 8000, MemoryUse::Upload); }),
              ::testing::HasSubstr("memory heap 1 has 4096 bytes, of which 0 are taken"));
}

TEST_F(EmbedDrivers, AQueueFamilyThatOnlyComputes) {
  expect_equal_bytes([](auto& pretence) { pretence.separate_compute = true; },
                     [](const auto& told) { EXPECT_EQ(told.compute_family, 1u); });
  EXPECT_EQ(PretendedDriver::used_families(), std::set<std::uint32_t>{1});
}

// As GPUs have it, where graphics computes beside a family that only computes.
TEST_F(EmbedDrivers, AQueueFamilyThatOnlyComputesIsPreferred) {
  PretendedDriver::pretence().separate_compute = true;
  PretendedDriver::pretence().graphics_compute = true;
  open();
  EXPECT_EQ(own_->capabilities().compute_family, 1u);
  submitter_->run([](VkCommandBuffer) {});
  EXPECT_EQ(PretendedDriver::used_families(), std::set<std::uint32_t>{1});
}

TEST_F(EmbedDrivers, HostsHandTheirBuffersFromFamilyToFamily) {
  PretendedDriver::pretence().separate_compute = true;
  open();
  const PolygonMesh mesh = test::icosphere(1);
  const HostTopology topology = topology_of(mesh);
  HostFrame frame = frame_of(topology);
  frame.set_points(mesh);
  HostCommands compute(*own_);
  const auto hand_over = [&](VkCommandBuffer commands, const Buffer& buffer, std::uint32_t from,
                             std::uint32_t to) {
    VkBufferMemoryBarrier barrier{VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER};
    barrier.srcAccessMask = kExitScope.accesses;
    barrier.dstAccessMask = kEntryScope.accesses;
    barrier.srcQueueFamilyIndex = from;
    barrier.dstQueueFamilyIndex = to;
    barrier.buffer = buffer.handle();
    barrier.size = VK_WHOLE_SIZE;
    compute.vk().vkCmdPipelineBarrier(commands, kExitScope.stages, kEntryScope.stages, 0, 0,
                                      nullptr, 1, &barrier, 0, nullptr);
  };
  compute.record([&](VkCommandBuffer commands) {
    hand_over(commands, frame.points, 0, 1);
    frame.record(commands, iterations(30));
    hand_over(commands, frame.output, 1, 0);
  });
  compute.submit();
  compute.wait();
  EXPECT_LT(difference(frame.vertices(), surface_by_cpu(mesh, mesh, {})).distance, 4e-6);
  // The host's two and none of planish's own.
  EXPECT_EQ(PretendedDriver::transfers(),
            (std::map<std::pair<std::uint32_t, std::uint32_t>, int>{{{0, 1}, 1}, {{1, 0}, 1}}));
}

TEST_F(EmbedDrivers, DevicesThatAreLostInTheMiddleAreReported) {
  const StencilTable masks = torus_masks(8, 8);
  const std::vector<glm::dvec3> initial = random_points(64);
  const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
  const test::FairCase fair(mesh);
  const auto in_steps = [&](const std::shared_ptr<VulkanMachine>& machine) {
    VulkanSolve solve(machine, masks.view());
    solve.begin(initial);
    static_cast<void>(solve.run(std::vector<StepCoefficients>(3, {0, 1}), -1));
    static_cast<void>(solve.displacement());
  };
  const auto in_nets = [&](const std::shared_ptr<VulkanMachine>& machine) {
    static_cast<void>(
        build_fair_net(*machine, make_fair_topology(fair.mesh, fair.subdivision), fair.given, {}));
  };
  for (const auto& work :
       {std::function<void(const std::shared_ptr<VulkanMachine>&)>(in_steps), {in_nets}}) {
    const std::map<std::string, int> before = PretendedDriver::alive();
    int lost = 0;
    for (bool done = false; !done; lost += lost < 4 ? 1 : 4) {
      PretendedDriver::pretence().submissions_left = lost;
      try {
        work(std::make_shared<VulkanMachine>(device_options(), ContextOptions{}));
        done = true;
      } catch (const VulkanError& error) {
        EXPECT_EQ(error.code(), ErrorCode::DeviceLost);
        EXPECT_EQ(error.result(), VK_ERROR_DEVICE_LOST);
        EXPECT_STREQ(error.what(), "vkQueueSubmit: VK_ERROR_DEVICE_LOST");
      }
      ASSERT_EQ(PretendedDriver::alive(), before) << "after " << lost << " submissions";
      ASSERT_LT(lost, 200);
    }
    EXPECT_GT(lost, 5);
    PretendedDriver::pretence().submissions_left = -1;
  }
}

// What hosts and drivers do wrong or lack: calls that fail, memory that is split, limits that are
// low.

class EmbedFaults : public Embedding {
 protected:
  /// Calls `make`, whose fallible calls fail one after another, until none does. Nothing must be
  /// left of a failed attempt, but for one kind that a Context keeps until its own end.
  void fail_each_call(const std::function<void()>& make, const std::string& kept = {}) {
    const std::map<std::string, int> before = alive_without(kept);
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
      ASSERT_EQ(alive_without(kept), before) << "after failure " << failures + 1;
      ASSERT_LT(failures, 2000);
    }
    PretendedDriver::pretence().failing_call = 0;
    std::cout << "  " << failures << " calls failed in turn\n";
    EXPECT_GT(failures, 0);
  }

  std::vector<Vertex> surface_of(const PolygonMesh& mesh, int level) {
    const HostTopology topology = topology_of(mesh, {.level = level}, {.max_vertex_stride = 24});
    slice_count_ = topology.device.slice_count();
    HostFrame frame = frame_of(topology);
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
  with_both_variants([&] {
    fail_each_call(
        [&] {
          const DeviceSystem tables(*context_, system,
                                    {.answers_places = true, .takes_edits = true});
          const Buffer vertices(*context_, 1 << 20, MemoryUse::Device);
          const MovedPoints moved{vertices.handle(), 1 << 19, 9};
          const vulkan::Solve frame(
              *context_, tables,
              {.vertices = {vertices.handle()},
               .further_slots = {{.vertices = {vertices.handle()}, .moved = moved}},
               .instances = 3,
               .moved = moved});
          const Places places(*context_, tables, frame,
                              {.list = {.count = 9}, .results = {.buffer = vertices.handle()}});
          const Tessellation levels(*context_, tables, frame,
                                    {.vertices = {vertices.handle()}, .places = {3, 2}});
        },
        "Pipeline");
  });
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

// Every dispatch is looked at; llvmpipe's kernels do 16 chunks a work group. Vectors take more
// groups than there may be, whose lanes go on.
TEST_F(EmbedFaults, LowLimitsSliceWithEqualResults) {
  struct Row {
    const char* name;
    PolygonMesh mesh;
    int level;
    std::uint32_t range, groups;  // 0: as many as there are
  };
  const Row rows[] = {
      // A level's points within one binding, more than one work group of rows: small meshes only.
      {"sphere of 4 KiB", test::icosphere(0), 2, 4096, 0},
      {"tetrahedron of 4 KiB", test::tetrahedron(), 3, 4096, 0},
      {"torus of 8 KiB", test::torus(12, 7, 2, 0.7), 1, 8192, 0},
      {"torus of few groups", test::torus(40, 30, 2, 0.7), 2, 0, 6},
      {"creases of few groups", test::with_random_creases(test::random_open_mesh(2), 0.1, 3), 2, 0,
       6}};
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant})
    for (const Row& row : rows) {
      SCOPED_TRACE(row.name);
      open({.variant = variant});
      const std::vector<Vertex> whole = surface_of(row.mesh, row.level);
      const std::size_t whole_slices = slice_count_;
      const bool takes_many = variant.chunks_per_group > 1;
      const std::uint32_t groups = takes_many ? std::min(row.groups, 1u) : row.groups;
      PretendedDriver::pretence().storage_range = row.range;
      PretendedDriver::pretence().group_count = groups;
      open({.variant = variant});
      if (row.range > 0) {
        EXPECT_EQ(context_->max_storage_range(), row.range);
      }
      if (groups > 0) {
        EXPECT_EQ(context_->max_group_count(), groups);
      }
      EXPECT_TRUE(same_bits(surface_of(row.mesh, row.level), whole));
      PretendedDriver::pretence() = {};
      EXPECT_GT(slice_count_, whole_slices);
    }
}

// Devices need not allow more than 4096 allocations, of all that a host has.
TEST_F(EmbedFaults, SmallBuffersShareAllocations) {
  const HostTopology topology(*context_, *submitter_, test::icosphere(1));
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
  EXPECT_THAT(test::message_of(ErrorCode::OutOfMemory,
                               [&] { static_cast<void>(surface_of(test::icosphere(2), 2)); }),
              ::testing::HasSubstr("maxStorageBufferRange is 4096"));
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

// What an object takes of a host's device: a block for each use of memory, and one pool.
using enum MemoryUse;

class EmbedMemory : public Embedding {
 protected:
  /// Pools are looked at as well: as many as `pools`.
  std::map<MemoryUse, int> taken_by(HostBlocks& blocks, int pools,
                                    const std::function<void()>& make) {
    blocks.taken.clear();
    const int before = PretendedDriver::count("vkCreateDescriptorPool");
    make();
    EXPECT_EQ(PretendedDriver::count("vkCreateDescriptorPool") - before, pools);
    return blocks.taken;
  }
};

TEST_F(EmbedMemory, IsABlockForEachUseAndAPoolForAnObject) {
  HostBlocks blocks(own_->host_device(), own_->capabilities().memory);
  HostDevice host = own_->host_device();
  host.memory = blocks.hooks();
  Context context(host);
  const Buffer vertices(context, 1 << 20, Device);
  for (const SystemOptions& options : {SystemOptions{.levels = {1, 2}},
                                       {.levels = {1, 2}, .within = 0.01},
                                       {.levels = {1, 2}, .method = InterpolationMethod::Fair}}) {
    const bool is_fair = options.method == InterpolationMethod::Fair;
    const bool takes_edits = !is_fair && options.within == 0;
    const System system(test::icosphere(1), options);
    const DeviceSystemOptions wanted_tables{.answers_places = true, .takes_edits = takes_edits};
    SolveOptions wanted{
        .vertices = {vertices.handle()},
        .further_slots = {{.vertices = {vertices.handle()}}, {.vertices = {vertices.handle()}}}};
    if (takes_edits) wanted.moved = {vertices.handle(), 1 << 19, 9};
    const PlacesOptions asked{.list = {.count = 9}, .results = {.buffer = vertices.handle()}};
    std::optional<DeviceSystem> tables;
    std::optional<vulkan::Solve> solve;
    std::optional<Tessellation> levels;
    std::optional<Places> places;
    const std::map<MemoryUse, int> one = {{Device, 1}}, two = {{Device, 1}, {Upload, 1}};
    EXPECT_EQ(taken_by(blocks, 0, [&] { tables.emplace(context, system, wanted_tables); }), one);
    EXPECT_EQ(taken_by(blocks, 1, [&] { solve.emplace(context, *tables, wanted); }),
              is_fair ? one : two);
    EXPECT_EQ(taken_by(blocks, 1,
                       [&] {
                         levels.emplace(context, *tables, *solve,
                                        TessellationOptions{.vertices = {vertices.handle()}});
                       }),
              two);
    EXPECT_EQ(taken_by(blocks, 1, [&] { places.emplace(context, *tables, *solve, asked); }), one);
  }
}

// Of memory that is not coherent, too, whose blocks lie in atoms.
TEST_F(EmbedMemory, IsInSeveralBlocksWhereOneWouldBeAboveTheLimit) {
  const PolygonMesh mesh = test::torus(40, 30, 2, 0.7);
  const auto surface = [&](int& allocations) {
    const int before = PretendedDriver::count("vkAllocateMemory");
    const HostTopology topology = topology_of(mesh, {.level = 2}, {.max_vertex_stride = 24});
    HostFrame frame = frame_of(topology);
    std::vector<Vertex> vertices = run(frame, mesh, iterations(30));
    allocations = PretendedDriver::count("vkAllocateMemory") - before;
    return vertices;
  };
  with_both_variants([&] {
    const ContextOptions options{.variant = context_->variant()};
    int few = 0, many = 0;
    const std::vector<Vertex> whole = surface(few);
    PretendedDriver::pretence().split_memory = true;
    PretendedDriver::pretence().allocation_size = 700'000;
    open(options);
    const std::vector<Vertex> cut = surface(many);
    EXPECT_GT(many, few);
    EXPECT_TRUE(same_bits(cut, whole));
    // Nothing is taken of what is too large as a whole.
    const int before = PretendedDriver::count("vkAllocateMemory");
    EXPECT_THROW(Buffer(*context_, 700'001, Device), Error);
    EXPECT_EQ(PretendedDriver::count("vkAllocateMemory"), before);
    PretendedDriver::pretence() = {};
  });
}

}  // namespace
}  // namespace planish::testing
