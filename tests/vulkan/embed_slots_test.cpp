// One Solve for all frames in flight: the bits of a Solve for each, and what slots are for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <list>
#include <optional>
#include <string>

#include "support/calls.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;
using ::testing::HasSubstr;

// A host that waits for a frame only where it wants its slot back. Slots differ in layout; their
// frames' own Solves are not used.
class SlotsHost {
 public:
  SlotsHost(Context& context, const OwnDevice& device, const HostTopology& topology, int count,
            std::uint32_t instances = 1) {
    constexpr Layout kLayouts[] = {{}, {20, 32, 16, 0}, {64, 40, 4, 24, 12}};
    for (int i = 0; i < count; ++i)
      slots_.emplace_back(context, device, topology, kLayouts[i % 3], instances);
    SolveOptions options;
    options.instances = instances;
    for (const Slot& slot : slots_) {
      const Layout& layout = slot.frame.layout;
      options.further_slots.push_back(
          {{slot.frame.points.handle()},
           {slot.frame.output.handle(), layout.offset, layout.stride, layout.position_offset,
            layout.normal_offset, slot.frame.instance_stride()}});
    }
    options.given = options.further_slots[0].given;
    options.vertices = options.further_slots[0].vertices;
    options.further_slots.erase(options.further_slots.begin());
    solve_.emplace(context, topology.device, options);
  }
  ~SlotsHost() {
    for (Slot& slot : slots_) wait(slot);
  }
  SlotsHost(const SlotsHost&) = delete;
  SlotsHost& operator=(const SlotsHost&) = delete;

  // A pose for each instance. Frames before it may still run.
  void submit(int number, const std::vector<PolygonMesh>& poses, SolveParameters parameters) {
    Slot& slot = at(number);
    wait(slot);
    for (std::uint32_t i = 0; i < poses.size(); ++i) slot.frame.set_points(poses[i], i);
    parameters.slot = static_cast<std::uint32_t>(number);
    slot.commands.record([&](VkCommandBuffer commands) {
      solve_->record_solve(commands, parameters);
      solve_->record_evaluate(commands, {.slot = parameters.slot});
      solve_->record_status(commands, slot.frame.report.handle(), 0);
    });
    slot.commands.submit();
    slot.is_under_way = true;
  }
  // Of that frame, where its slot was not given away since.
  HostFrame& done(int number) {
    wait(at(number));
    return at(number).frame;
  }
  [[nodiscard]] const vulkan::Solve& solve() const { return *solve_; }

 private:
  struct Slot {
    Slot(Context& context, const OwnDevice& device, const HostTopology& topology,
         const Layout& layout, std::uint32_t instances)
        : frame(context, topology, layout, 64, instances), commands(device) {}
    HostFrame frame;
    HostCommands commands;
    bool is_under_way = false;
  };
  static void wait(Slot& slot) {
    if (slot.is_under_way) slot.commands.wait();
    slot.is_under_way = false;
  }
  Slot& at(int number) {
    return *std::next(slots_.begin(), number % static_cast<int>(slots_.size()));
  }

  std::list<Slot> slots_;
  std::optional<vulkan::Solve> solve_;
};

class EmbedSlots : public Embedding {
 protected:
  // All frames that are in flight together are looked at when the last of them was submitted.
  void expect_frames(const HostTopology& topology, const PolygonMesh& mesh, int slot_count,
                     const SolveParameters& parameters) {
    SlotsHost host(*context_, *own_, topology, slot_count);
    HostFrame alone(*context_, topology);
    for (int first = 0; first < 3 * slot_count; first += slot_count) {
      for (int i = first; i < first + slot_count; ++i) host.submit(i, {posed(mesh, i)}, parameters);
      for (int i = first; i < first + slot_count; ++i) {
        const std::vector<Vertex> expected = run(alone, posed(mesh, i), parameters);
        HostFrame& found = host.done(i);
        EXPECT_TRUE(same_bits(found.vertices(), expected)) << i;
        EXPECT_EQ(bits_of(found.status()), bits_of(alone.status())) << i;
      }
    }
  }
};

TEST_F(EmbedSlots, BitsAreThoseOfASolveForEachFrame) {
  SolveParameters stopped = iterations(40);
  stopped.stop_error = 1e-4f;
  with_both_variants([&] {
    const PolygonMesh torus = test::torus(24, 14, 2, 0.7);
    const PolygonMesh open = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
    for (const PolygonMesh& mesh : {torus, open}) {
      HostTopology topology(*context_, mesh);
      topology.upload(*submitter_);
      for (const int slot_count : {2, 3})
        for (const SolveParameters& parameters : {iterations(12), stopped})
          expect_frames(topology, mesh, slot_count, parameters);
    }
  });
}

TEST_F(EmbedSlots, OtherMethodsHaveThem) {
  const PolygonMesh mesh = test::icosphere(1);
  SystemOptions fair, within;
  fair.method = InterpolationMethod::Fair;
  within.within = 0.02;
  for (const SystemOptions& options : {fair, within}) {
    HostTopology topology(*context_, mesh, options);
    topology.upload(*submitter_);
    expect_frames(topology, mesh, 2, iterations(12));
  }
}

TEST_F(EmbedSlots, TablesInSlicesHaveThem) {
  PretendedDriver::pretence().storage_range = 32768;
  open();
  const PolygonMesh mesh = test::torus(24, 14, 2, 0.7);
  HostTopology topology(*context_, mesh);
  ASSERT_GT(topology.device.slice_count(), 2u);
  topology.upload(*submitter_);
  expect_frames(topology, mesh, 3, iterations(12));
}

TEST_F(EmbedSlots, InstancesHaveThem) {
  const PolygonMesh mesh = test::icosphere(1);
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  constexpr std::uint32_t kCount = 3;
  SlotsHost host(*context_, *own_, topology, 2, kCount);
  HostFrame alone(*context_, topology);
  const auto pose = [&](int frame, std::uint32_t instance) {
    return posed(mesh, frame + 5 * static_cast<int>(instance));
  };
  for (int i = 0; i < 5; ++i) {
    host.submit(i, {pose(i, 0), pose(i, 1), pose(i, 2)}, iterations(9));
    if (i == 0) continue;
    for (std::uint32_t k = 0; k < kCount; ++k)
      EXPECT_TRUE(
          same_bits(host.done(i - 1).vertices(k), run(alone, pose(i - 1, k), iterations(9))))
          << i << " " << k;
  }
}

// A warm start goes on from the last frame, whatever its slot: the bits of one Solve that does one
// frame after the other, and fewer iterations than Solves that take turns.
TEST_F(EmbedSlots, WarmStartsGoOnFromTheLastFrame) {
  const PolygonMesh mesh = test::torus(30, 20, 2, 0.7);
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  const auto pose = [&](int frame) {
    PolygonMesh result = mesh;
    for (glm::dvec3& p : result.positions) {
      const double angle = 0.1 * frame * p.z;
      p = {std::cos(angle) * p.x - std::sin(angle) * p.y,
           std::sin(angle) * p.x + std::cos(angle) * p.y, p.z};
    }
    return result;
  };
  SolveParameters parameters = iterations(60);
  parameters.stop_error = static_cast<float>(1e-6 * topology.system.diagonal());
  SlotsHost host(*context_, *own_, topology, 2);
  HostFrame alone(*context_, topology), turns[] = {{*context_, topology}, {*context_, topology}};
  std::uint32_t by_slots = 0, by_turns = 0;
  for (int i = 0; i < 8; ++i) {
    parameters.warm_start = i > 0;
    host.submit(i, {pose(i)}, parameters);
    const std::vector<Vertex> expected = run(alone, pose(i), parameters);
    parameters.warm_start = i > 1;
    static_cast<void>(run(turns[i % 2], pose(i), parameters));
    HostFrame& found = host.done(i);
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
  HostTopology topology(*context_, rest);
  topology.upload(*submitter_);
  SlotsHost host(*context_, *own_, topology, 3);
  host.submit(0, {turned}, iterations(14));
  host.submit(1, {rest}, iterations(14));
  host.submit(2, {shifted}, iterations(14));
  const std::vector<Vertex> after = host.done(2).vertices(), before = host.done(1).vertices(),
                            quarter = host.done(0).vertices();
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
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  HostFrame slots[] = {{*context_, topology}, {*context_, topology}}, alone(*context_, topology);
  SolveOptions options;
  options.vertices = {slots[0].output.handle()};
  options.further_slots = {{{}, {slots[1].output.handle()}}};
  const vulkan::Solve solve(*context_, topology.device, options);
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

TEST_F(EmbedSlots, WrongSlotsAreRefusedByName) {
  const HostTopology topology(*context_, test::icosphere(1));
  const Buffer buffer(*context_, 1 << 20, MemoryUse::Device);
  const auto refuse = [&](const SolveOptions& options, const char* words) {
    const std::map<std::string, int> before = PretendedDriver::alive();
    try {
      const vulkan::Solve solve(*context_, topology.device, options);
      ADD_FAILURE() << "nothing thrown: " << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_THAT(error.what(), HasSubstr(words));
    }
    EXPECT_EQ(PretendedDriver::alive(), before);
  };
  refuse({.further_slots = std::vector<FrameSlot>(16)}, "17 slots are more than 16");
  refuse({.further_slots = {{}, {.given = {buffer.handle(), 0, 8}}}}, "12 or more apart");
  refuse({.further_slots = {{.vertices = {buffer.handle(), 0, 20}}}}, "does not hold 12 bytes");
  refuse({.further_slots = {{.vertices = {.buffer = buffer.handle(), .instance_stride = 40}}},
          .instances = 2},
         "vertices of an instance take");
}

// Bytes of one buffer: of points, vertices of two slots and a list. What is written is nobody's
// else.
TEST_F(EmbedSlots, SharedBytesAreRefusedByName) {
  const PolygonMesh mesh = test::icosphere(1);  // 42 vertices
  const System system(mesh, {.level = 0});
  const DeviceSystem tables(*context_, system, {.takes_edits = true});
  const Buffer buffer(*context_, 1 << 20, MemoryUse::Device);
  const VkBuffer all = buffer.handle();
  const auto message = [&](const SolveOptions& options) {
    const std::map<std::string, int> before = PretendedDriver::alive();
    const std::string text = test::message_of(
        ErrorCode::InvalidArgument, [&] { const vulkan::Solve solve(*context_, tables, options); });
    std::map<std::string, int> after = PretendedDriver::alive();
    after.erase("Pipeline");  // a Context keeps them
    std::map<std::string, int> alive = before;
    alive.erase("Pipeline");
    EXPECT_EQ(after, alive);
    return text;
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
  EXPECT_EQ(message(with(0, first, second, list)), "no error");
  EXPECT_EQ(message(with(0, first, first, list)), "no error");  // written one after the other
  EXPECT_EQ(message(with(0, 0, second, list)),
            "given points of slot 0 and positions of slot 0 share bytes 0 to 503 of a buffer, so "
            "that what is read would be written over; give each bytes of its own");
  EXPECT_THAT(message(with(0, second, kPoints - 4, list)),
              HasSubstr("given points of slot 0 and positions of slot 1 share bytes 500 to 503"));
  EXPECT_THAT(message(with(0, first, second, list - 4)),
              HasSubstr("the list of moved points of slot 0 and normals of slot 1 share bytes"));
  SolveOptions options;
  options.vertices = {.buffer = all, .normal_offset = 8};
  EXPECT_THAT(message(options),
              HasSubstr("positions of slot 0 and normals of slot 0 share bytes 8 to "));
  options.vertices = {
      .buffer = all, .stride = 12, .normal_offset = 0, .attributes = {all, 42 * 12 - 4, 12}};
  EXPECT_THAT(message(options), HasSubstr("share bytes 500 to 503 of a buffer, and both are"));
  // Element by element, and instance by instance.
  options.vertices = {
      .buffer = all, .offset = 12, .stride = 36, .normal_offset = 12, .instance_stride = 5040};
  options.given = {all, 0, 36, 5040};
  options.instances = 3;
  EXPECT_EQ(message(options), "no error");
  options.given.offset = 8;
  EXPECT_THAT(message(options), HasSubstr("given points of slot 0 and positions of slot 0 share"));
  options.vertices = {.buffer = all, .offset = kPoints, .instance_stride = kPoints + kVertices};
  options.given = {all, 0, 12, kPoints + kVertices};
  EXPECT_EQ(message(options), "no error");
  options.given.offset = 4;
  EXPECT_THAT(message(options), HasSubstr("given points of slot 0 and positions of slot 0 share"));
}

}  // namespace
}  // namespace planish::testing
