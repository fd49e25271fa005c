// Drivers that differ: every kernel of a frame, of both methods, gives the same bits on each.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <functional>
#include <numbers>

#include "fair/fair_case.h"
#include "planish/surface/evaluate.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/device/driver.h"
#include "support/expect_error.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"
#include "vulkan/large_rings.h"
#include "vulkan/tables.h"

namespace planish::testing {
namespace {

using namespace vulkan;

class EmbedDrivers : public Embedding {
 protected:
  /// Vertices and status of frames of both methods, one by one, beside each other and as instances,
  /// and places on a surface.
  std::vector<std::byte> frames() {
    std::vector<std::byte> bytes;
    const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
    SystemOptions progressive, fair;
    progressive.level = fair.level = 1;
    fair.method = InterpolationMethod::Fair;
    HostTopology first(*context_, mesh, progressive), second(*context_, mesh, fair);
    HostFrame one(*context_, first), other(*context_, second);
    HostFrame crowd(*context_, first, {}, 64, 3);
    SolveParameters stopped = iterations(20);
    stopped.stop_error = 1e-4f;
    for (HostTopology* topology : {&first, &second}) topology->upload(*submitter_);
    for (const int pose : {0, 1}) {
      one.set_points(posed(mesh, pose));
      other.set_points(posed(mesh, pose));
      for (std::uint32_t i = 0; i < 3; ++i)
        crowd.set_points(posed(mesh, pose + static_cast<int>(i)), i);
      submitter_->run([&](VkCommandBuffer commands) {
        crowd.record(commands, stopped);
        if (pose == 0) {
          one.record(commands, stopped);
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
        const std::vector<Vertex> vertices = frame->vertices(instance);
        const GpuStatus status = frame->status(instance);
        const auto add = [&](std::span<const std::byte> more) {
          bytes.insert(bytes.end(), more.begin(), more.end());
        };
        add(std::as_bytes(std::span(vertices)));
        add(std::as_bytes(std::span(&status, 1)));
      }
    }
    // Of few kinds of corners: the weights of each take 55 kB, and tables may be a megabyte at
    // most.
    for (const std::vector<std::byte>& more :
         {places(test::icosphere(1)), frame_of_large_rings(InterpolationMethod::Progressive),
          frame_of_large_rings(InterpolationMethod::Fair)})
      bytes.insert(bytes.end(), more.begin(), more.end());
    return bytes;
  }

  /// Three instances, or one of the fair method.
  std::vector<std::byte> frame_of_large_rings(InterpolationMethod method) {
    const PolygonMesh mesh = hub_of(40, 3, 2 * std::numbers::pi);
    SystemOptions options;
    options.level = 1;
    options.method = method;
    const std::uint32_t count = method == InterpolationMethod::Fair ? 1 : 3;
    HostTopology topology(*context_, mesh, options);
    HostFrame frame(*context_, topology, {}, 64, count);
    topology.upload(*submitter_);
    for (std::uint32_t i = 0; i < count; ++i) frame.set_points(posed(mesh, static_cast<int>(i)), i);
    submitter_->run([&](VkCommandBuffer commands) { frame.record(commands, iterations(9)); });
    std::vector<std::byte> bytes;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::vector<Vertex> vertices = frame.vertices(i);
      const auto more = std::as_bytes(std::span(vertices));
      bytes.insert(bytes.end(), more.begin(), more.end());
    }
    return bytes;
  }

  /// Position, normal and derivatives at places all over a solved surface.
  std::vector<std::byte> places(const PolygonMesh& mesh) {
    const System system(mesh);
    const DeviceSystem tables(*context_, system, {.answers_places = true});
    const auto mapped = [&](std::span<const std::byte> bytes) {
      Buffer buffer(*context_, bytes.size(), MemoryUse::Upload);
      std::memcpy(buffer.mapped().data(), bytes.data(), bytes.size());
      buffer.flush();
      return buffer;
    };
    Buffer staging(*context_, tables.upload_bytes(), MemoryUse::Upload);
    tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
    staging.flush();
    const std::vector<glm::vec3> given(mesh.positions.begin(), mesh.positions.end());
    const Buffer points = mapped(std::as_bytes(std::span(given)));
    struct Record {
      std::int32_t face;
      float u, v;
    };
    std::vector<Record> records;
    for (std::int32_t face = 0; face < mesh.face_count(); ++face)
      for (const float at : {0.0f, 0.2f, 0.49f}) records.push_back({face, at, 0.5f * at});
    const Buffer list = mapped(std::as_bytes(std::span(records)));
    const auto count = static_cast<std::uint32_t>(records.size());
    Buffer results(*context_, 88 * count, MemoryUse::Download);
    const vulkan::Solve solve(*context_, tables, {.given = {points.handle()}});
    const Places asked(*context_, tables, solve,
                       {{list.handle(), 0, 12, count}, {.buffer = results.handle()}});
    submitter_->run([&](VkCommandBuffer commands) {
      tables.record_upload(commands, staging.handle(), 0);
      solve.record_solve(commands, iterations(5));
      solve.record_surface(commands);
      asked.record_evaluate(commands);
    });
    results.invalidate();
    return {results.mapped().begin(), results.mapped().begin() + 88 * count};
  }

  /// What the command's backend makes: steps, conjugate gradients, stencils, limit points, normals.
  std::vector<std::byte> by_backend(const ContextOptions& options) {
    const auto backend =
        vulkan::make_backend(std::make_shared<VulkanMachine>(device_options(), options));
    std::vector<std::byte> bytes;
    const auto add = [&](const auto& values) {
      const auto more = std::as_bytes(std::span(values));
      bytes.insert(bytes.end(), more.begin(), more.end());
    };
    const StencilTable masks = torus_masks(30, 20);
    const std::vector<glm::dvec3> given = random_points(600);
    const auto solve = backend->make_solve(masks.view());
    solve->begin(given);
    for (const ErrorNorms& error :
         solve->run(std::vector<StepCoefficients>(5, {0.2, 1.1}), -1).errors)
      add(std::array{error.max, error.rms});
    add(solve->displacement());
    add(std::array{solve->cg_begin(given, std::vector<double>(600, 4.0)), solve->cg_apply()});
    const auto advance = solve->cg_advance(glm::dvec3(0.9, 1.0, 1.1));
    add(std::array{advance.residual_square});
    add(std::array{advance.error.max, advance.error.rms});
    solve->cg_turn(glm::dvec3(0.3));
    add(std::array{solve->cg_apply()});
    add(solve->displacement());
    const StencilTable table = random_table(500, 600);
    const auto source = backend->upload(given), target = backend->allocate(510);
    backend->apply(table.view(), *source, *target, 10);
    const std::vector<glm::dvec3> applied = backend->download(*target);
    add(std::span(applied).subspan(10));
    const StencilTable limit = random_rows(500, 600);
    std::vector<glm::dvec3> positions(500);
    std::vector<glm::vec3> normals(500);
    backend->apply_limit(limit.view(), *source, positions, normals);
    add(positions);
    add(normals);
    return bytes;
  }

  /// Of the driver as it is; made once a process, since kernels compile anew with every context.
  const std::vector<std::byte>& expected_frames(const ContextOptions& options, bool hardware) {
    static std::vector<std::byte> made[2];
    std::vector<std::byte>& expected = made[hardware ? 1 : 0];
    if (expected.empty()) expected = of_driver(options, [] {});
    return expected;
  }

  std::vector<std::byte> of_driver(const ContextOptions& options,
                                   const std::function<void()>& check) {
    std::vector<std::byte> bytes = by_backend(options);
    open(options);
    check();
    const std::vector<std::byte> more = frames();
    close();
    bytes.insert(bytes.end(), more.begin(), more.end());
    return bytes;
  }

  /// The same on the driver as it is and on one that differs, reading both ways.
  void expect_equal_frames(
      const std::function<void(PretendedDriver::Pretence&)>& differ,
      const std::function<void()>& check = [] {}) {
    for (const bool hardware : {false, true}) {
      ContextOptions options;
      options.variant = hardware ? kHardwareVariant : kSoftwareVariant;
      const std::vector<std::byte>& expected = expected_frames(options, hardware);
      differ(PretendedDriver::pretence());
      const std::vector<std::byte> found = of_driver(options, check);
      PretendedDriver::pretence() = {};
      EXPECT_GT(expected.size(), 1000u);
      EXPECT_EQ(found, expected);
    }
  }
};

TEST_F(EmbedDrivers, SubgroupsOfAnySize) {
  for (const std::uint32_t size : {1u, 32u, 64u, 128u})
    expect_equal_frames([&](auto& pretence) { pretence.subgroup_size = size; },
                        [&] { EXPECT_EQ(own_->capabilities().subgroup_size, size); });
}

TEST_F(EmbedDrivers, NoSubgroupOperations) {
  expect_equal_frames([](auto& pretence) { pretence.no_subgroup_operations = true; });
}

TEST_F(EmbedDrivers, MemoryThatIsNotCoherent) {
  expect_equal_frames([](auto& pretence) { pretence.split_memory = true; });
  EXPECT_GT(PretendedDriver::count("vkFlushMappedMemoryRanges"), 4);
  EXPECT_GT(PretendedDriver::count("vkInvalidateMappedMemoryRanges"), 4);
  EXPECT_EQ(PretendedDriver::illegal_maps(), 0);
}

// As of a discrete GPU: a heap of its own, one that the host sees too, too small for an upload, and
// the host's, smaller than what the device's holds.
TEST_F(EmbedDrivers, ASmallHeapThatDeviceAndHostSee) {
  expect_equal_frames([](auto& pretence) {
    pretence.bar_bytes = 4096;
    pretence.host_bytes = 1u << 20;
  });
  EXPECT_EQ(PretendedDriver::illegal_maps(), 0);
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

TEST_F(EmbedDrivers, RangesOf128MebibytesAndFewTexels) {
  expect_equal_frames(
      [](auto& pretence) {
        pretence.storage_range = 128u << 20;
        pretence.texel_elements = 65536;  // what every device has
      },
      [&] { EXPECT_EQ(own_->capabilities().max_storage_range, 128u << 20); });
}

TEST_F(EmbedDrivers, NoTimestamps) {
  expect_equal_frames([](auto& pretence) { pretence.no_timestamps = true; },
                      [&] { EXPECT_EQ(own_->capabilities().timestamp_bits, 0u); });
}

TEST_F(EmbedDrivers, APortabilitySubset) {
  expect_equal_frames([](auto& pretence) { pretence.portability_subset = true; });
}

TEST_F(EmbedDrivers, AQueueFamilyThatOnlyComputes) {
  expect_equal_frames([](auto& pretence) { pretence.separate_compute = true; },
                      [&] { EXPECT_EQ(own_->capabilities().compute_family, 1u); });
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
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  HostFrame frame(*context_, topology);
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
    static_cast<void>(solve.cg_begin(initial, std::vector<double>(64, 4.0)));
    static_cast<void>(solve.cg_apply());
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
        EXPECT_STREQ(error.what(), "vkQueueSubmit: VK_ERROR_DEVICE_LOST");
      }
      ASSERT_EQ(PretendedDriver::alive(), before) << "after " << lost << " submissions";
      ASSERT_LT(lost, 200);
    }
    EXPECT_GT(lost, 5);
    PretendedDriver::pretence().submissions_left = -1;
  }
}

}  // namespace
}  // namespace planish::testing
