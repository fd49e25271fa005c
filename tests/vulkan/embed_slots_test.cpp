// One Solve for all frames in flight: the bits of a Solve for each, and what slots are for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <list>
#include <string>

#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;

class EmbedSlots : public Embedding {
 protected:
  // A frame with a pose for each instance.
  static void submit(FramesInFlight& host, int number, const std::vector<PolygonMesh>& poses,
                     SolveParameters parameters) {
    parameters.slot = static_cast<std::uint32_t>(number);
    HostFrame& frame = host.done(number).frame;
    for (std::uint32_t i = 0; i < poses.size(); ++i) frame.set_points(poses[i], i);
    host.submit(number, [&](VkCommandBuffer commands, FramesInFlight::Slot&) {
      host.solve().record_solve(commands, parameters);
      host.solve().record_evaluate(commands, {.slot = parameters.slot});
      host.solve().record_status(commands, frame.report.handle(), 0);
    });
  }
  // All frames that are in flight together are looked at when the last of them was submitted.
  void expect_frames(const HostTopology& topology, const PolygonMesh& mesh, int slot_count,
                     std::uint32_t instances, const SolveParameters& parameters) {
    FramesInFlight host(*context_, *own_, topology, slot_count, instances);
    HostFrame alone = frame_of(topology);
    const auto poses_of = [&](int frame) {
      std::vector<PolygonMesh> poses;
      for (std::uint32_t k = 0; k < instances; ++k)
        poses.push_back(posed(mesh, frame + 5 * static_cast<int>(k)));
      return poses;
    };
    for (int first = 0; first < 3 * slot_count; first += slot_count) {
      for (int i = first; i < first + slot_count; ++i) submit(host, i, poses_of(i), parameters);
      for (int i = first; i < first + slot_count; ++i)
        for (std::uint32_t k = 0; k < instances; ++k) {
          const std::vector<Vertex> expected = run(alone, poses_of(i)[k], parameters);
          HostFrame& found = host.done(i).frame;
          EXPECT_TRUE(same_bits(found.vertices(k), expected)) << i << " " << k;
          EXPECT_EQ(bits_of(found.status(k)), bits_of(alone.status())) << i << " " << k;
        }
    }
  }
};

TEST_F(EmbedSlots, BitsAreThoseOfASolveForEachFrame) {
  struct Row {
    const char* name;
    PolygonMesh mesh;
    SystemOptions options;
    std::uint32_t instances = 1;
  };
  const PolygonMesh sphere = test::icosphere(1);
  const Row rows[] = {{"torus", test::torus(24, 14, 2, 0.7), {}},
                      {"creased", test::with_random_creases(test::random_open_mesh(2), 0.1, 3), {}},
                      {"fair", sphere, {.method = InterpolationMethod::Fair}},
                      {"within", sphere, {.within = 0.02}},
                      {"instances", sphere, {}, 3}};
  with_both_variants([&] {
    for (const Row& row : rows) {
      SCOPED_TRACE(row.name);
      const HostTopology topology = topology_of(row.mesh, row.options);
      for (const int slot_count : {2, 3})
        for (const SolveParameters& parameters : {iterations(12), stopping(40, 1e-4)})
          expect_frames(topology, row.mesh, slot_count, row.instances, parameters);
    }
  });
}

TEST_F(EmbedSlots, TablesInSlicesHaveThem) {
  PretendedDriver::pretence().storage_range = 32768;
  open();
  const PolygonMesh mesh = test::torus(24, 14, 2, 0.7);
  const HostTopology topology = topology_of(mesh);
  ASSERT_GT(topology.device.slice_count(), 2u);
  expect_frames(topology, mesh, 3, 1, iterations(12));
}

// A warm start goes on from the last frame, whatever its slot: the bits of one Solve that does one
// frame after the other, and fewer iterations than Solves that take turns.
TEST_F(EmbedSlots, WarmStartsGoOnFromTheLastFrame) {
  const PolygonMesh mesh = test::torus(30, 20, 2, 0.7);
  const HostTopology topology = topology_of(mesh);
  const auto pose = [&](int frame) {
    PolygonMesh result = mesh;
    for (glm::dvec3& p : result.positions) {
      const double angle = 0.1 * frame * p.z;
      p = {std::cos(angle) * p.x - std::sin(angle) * p.y,
           std::sin(angle) * p.x + std::cos(angle) * p.y, p.z};
    }
    return result;
  };
  SolveParameters parameters = stopping(60, 1e-6 * topology.system.diagonal());
  FramesInFlight host(*context_, *own_, topology, 2);
  HostFrame alone = frame_of(topology), turns[] = {frame_of(topology), frame_of(topology)};
  std::uint32_t by_slots = 0, by_turns = 0;
  for (int i = 0; i < 8; ++i) {
    parameters.warm_start = i > 0;
    submit(host, i, {pose(i)}, parameters);
    const std::vector<Vertex> expected = run(alone, pose(i), parameters);
    parameters.warm_start = i > 1;
    static_cast<void>(run(turns[i % 2], pose(i), parameters));
    HostFrame& found = host.done(i).frame;
    EXPECT_TRUE(same_bits(found.vertices(), expected)) << i;
    EXPECT_EQ(bits_of(found.status()), bits_of(alone.status())) << i;
    EXPECT_EQ(turns[i % 2].status().state, SolveState::Converged);
    if (i < 2) continue;
    by_slots += found.status().iterations;
    by_turns += turns[i % 2].status().iterations;
  }
  RecordProperty("iterations_by_slots", static_cast<int>(by_slots));
  RecordProperty("iterations_by_turns", static_cast<int>(by_turns));
  EXPECT_LT(by_slots, by_turns);
}

// What the last slot has are the positions before: of a mesh that is turned by a right angle about
// an axis, exactly; of one that is shifted by what floats hold, but for the sums' last rounding.
TEST_F(EmbedSlots, MotionOfARigidMoveIsExact) {
  PolygonMesh rest = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
  for (glm::dvec3& p : rest.positions) p = glm::round(p * 4096.0) / 4096.0;
  PolygonMesh turned = rest, shifted = rest;
  const glm::dvec3 shift(0.5, -0.25, 0.125);
  for (glm::dvec3& p : turned.positions) p = {-p.y, p.x, p.z};
  for (glm::dvec3& p : shifted.positions) p += shift;
  const HostTopology topology = topology_of(rest);
  FramesInFlight host(*context_, *own_, topology, 3);
  submit(host, 0, {turned}, iterations(14));
  submit(host, 1, {rest}, iterations(14));
  submit(host, 2, {shifted}, iterations(14));
  const auto vertices = [&](int number) { return host.done(number).frame.vertices(); };
  const std::vector<Vertex> after = vertices(2), before = vertices(1), quarter = vertices(0);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const glm::vec3 p = before[i].position;
    ASSERT_EQ(quarter[i].position, glm::vec3(-p.y, p.x, p.z)) << i;
    ASSERT_EQ(after[i].normal, before[i].normal) << i;
    const glm::dvec3 motion = glm::dvec3(after[i].position) - glm::dvec3(p);
    for (int k = 0; k < 3; ++k) {
      const double size = std::max(std::abs(p[k]), std::abs(after[i].position[k]));
      ASSERT_NEAR(motion[k], shift[k], size * std::numeric_limits<float>::epsilon()) << i;
    }
  }
}

// Points from staging: the Solve's own buffer, one for all slots that want it.
TEST_F(EmbedSlots, StagedPointsServeSlotsWithoutABuffer) {
  const PolygonMesh mesh = test::icosphere(1);
  const HostTopology topology = topology_of(mesh);
  HostFrame slots[] = {frame_of(topology), frame_of(topology)}, alone = frame_of(topology);
  const vulkan::Solve solve(*context_, topology.device,
                            {.vertices = {slots[0].output.handle()},
                             .further_slots = {{{}, {slots[1].output.handle()}}}});
  std::list<HostCommands> commands;
  for (int i = 0; i < 2; ++i) {
    slots[i].set_points(posed(mesh, i));
    SolveParameters parameters = iterations(9);
    parameters.slot = static_cast<std::uint32_t>(i);
    commands.emplace_back(*own_).record([&](VkCommandBuffer buffer) {
      solve.record_given(buffer, slots[i].points.handle(), 0);
      solve.record_solve(buffer, parameters);
      solve.record_evaluate(buffer, {.slot = parameters.slot});
    });
  }
  for (HostCommands& each : commands) each.submit();
  for (HostCommands& each : commands) each.wait();
  for (int i = 0; i < 2; ++i)
    EXPECT_TRUE(same_bits(slots[i].vertices(), run(alone, posed(mesh, i), iterations(9)))) << i;
}

// By what is asked of the driver, in blocks of their own.
TEST_F(EmbedSlots, FurtherSlotsTakeNoMemory) {
  const PolygonMesh mesh = test::torus(300, 200, 2, 0.7);
  const System system(mesh, {.level = 1});
  const auto taken = [&](const auto& make) {
    open();
    const DeviceSystem tables(*context_, system);
    const std::uint64_t vertices = 24 * std::uint64_t(system.vertex_count());
    const Buffer host(*context_, vertices + 12 * mesh.positions.size(), MemoryUse::Device);
    const std::uint64_t before = context_->memory().peak_bytes();
    make(tables, SolveOptions{.given = {host.handle(), vertices}, .vertices = {host.handle()}});
    return context_->memory().peak_bytes() - before;
  };
  const auto one = taken([&](const DeviceSystem& tables, const SolveOptions& options) {
    const vulkan::Solve solve(*context_, tables, options);
  });
  const auto two = taken([&](const DeviceSystem& tables, const SolveOptions& options) {
    const vulkan::Solve first(*context_, tables, options), second(*context_, tables, options);
  });
  const auto slots = taken([&](const DeviceSystem& tables, SolveOptions options) {
    options.further_slots = {{options.given, options.vertices}, {options.given, options.vertices}};
    const vulkan::Solve solve(*context_, tables, options);
  });
  RecordProperty("bytes_of_one", std::to_string(one));
  RecordProperty("bytes_of_two_solves", std::to_string(two));
  EXPECT_EQ(slots, one);
  EXPECT_GT(two, one + 100 * mesh.positions.size());
}

// Bytes of one buffer: of points, vertices of two slots and a list. What is written is nobody's
// else.
TEST_F(EmbedSlots, SharedBytesAreRefusedByName) {
  const PolygonMesh mesh = test::icosphere(1);  // 42 vertices
  const System system(mesh, {.level = 0});
  const DeviceSystem tables(*context_, system, {.takes_edits = true});
  const Buffer buffer(*context_, 1 << 20, MemoryUse::Device);
  const VkBuffer all = buffer.handle();
  const auto expect_message = [&](const std::string& words, const SolveOptions& options) {
    expect_refusal(
        ErrorCode::InvalidArgument, words,
        [&] { const vulkan::Solve solve(*context_, tables, options); }, "Pipeline");
  };
  constexpr std::uint64_t kPoints = 42 * 12, kVertices = 42 * 24;
  const auto with = [&](VkDeviceSize points, VkDeviceSize first, VkDeviceSize second,
                        VkDeviceSize list) {
    SolveOptions options{.given = {all, points}, .vertices = {all, first}};
    options.further_slots = {{{all, points}, {all, second}, {}}};
    options.moved = {all, list, 9};
    return options;
  };
  const VkDeviceSize first = kPoints, second = first + kVertices, list = second + kVertices;
  expect_message("no error", with(0, first, second, list));
  expect_message("no error", with(0, first, first, list));  // written one after the other
  expect_message(
      "given points of slot 0 and positions of slot 0 share bytes 0 to 503 of a buffer, so "
      "that what is read would be written over; give each bytes of its own",
      with(0, 0, second, list));
  expect_message("given points of slot 0 and positions of slot 1 share bytes 500 to 503",
                 with(0, second, kPoints - 4, list));
  expect_message("the list of moved points of slot 0 and normals of slot 1 share bytes",
                 with(0, first, second, list - 4));
  SolveOptions options;
  options.vertices = {.buffer = all, .normal_offset = 8};
  expect_message("positions of slot 0 and normals of slot 0 share bytes 8 to ", options);
  options.vertices = {
      .buffer = all, .stride = 12, .normal_offset = 0, .attributes = {all, 42 * 12 - 4, 12}};
  expect_message("share bytes 500 to 503 of a buffer, and both are", options);
  // Element by element, and instance by instance.
  options.vertices = {
      .buffer = all, .offset = 12, .stride = 36, .normal_offset = 12, .instance_stride = 5040};
  options.given = {all, 0, 36, 5040};
  options.instances = 3;
  expect_message("no error", options);
  options.given.offset = 8;
  expect_message("given points of slot 0 and positions of slot 0 share", options);
  options.vertices = {.buffer = all, .offset = kPoints, .instance_stride = kPoints + kVertices};
  options.given = {all, 0, 12, kPoints + kVertices};
  expect_message("no error", options);
  options.given.offset = 4;
  expect_message("given points of slot 0 and positions of slot 0 share", options);
}

}  // namespace
}  // namespace planish::testing
