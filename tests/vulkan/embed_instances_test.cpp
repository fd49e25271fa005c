#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <set>
#include <utility>

#include "planish/mesh/mesh_parts.h"
#include "planish/vulkan/device/commands.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

// Instances of one mesh in one Solve: the bits of a Solve each, with the dispatches of one.

using namespace vulkan;

class EmbedInstances : public Embedding {
 protected:
  static constexpr std::uint32_t kCount = 5;

  // Poses that differ so much that they stop at different iterations.
  PolygonMesh pose_of(const PolygonMesh& rest, int frame, std::uint32_t instance) const {
    PolygonMesh pose = posed(rest, frame + 3 * static_cast<int>(instance));
    if (instance == small_)
      for (glm::dvec3& p : pose.positions) p *= small_size_;
    return pose;
  }

  std::uint32_t small_ = 2;
  double small_size_ = 0.02;

  /// A frame of all instances in one Solve, and of each by itself in the HostFrame that `alone`
  /// names; returns their iterations.
  std::vector<std::uint32_t> expect_same_bits(HostFrame& together,
                                              const std::function<HostFrame&(std::uint32_t)>& alone,
                                              int frame, const PolygonMesh& rest,
                                              const SolveParameters& parameters) {
    for (std::uint32_t i = 0; i < kCount; ++i) together.set_points(pose_of(rest, frame, i), i);
    submitter_->run([&](VkCommandBuffer commands) { together.record(commands, parameters); });
    std::vector<std::uint32_t> taken;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const std::vector<Vertex> expected = run(alone(i), pose_of(rest, frame, i), parameters);
      EXPECT_TRUE(same_bits(together.vertices(i), expected)) << frame << ", " << i;
      EXPECT_EQ(bits_of(together.status(i)), bits_of(alone(i).status())) << frame << ", " << i;
      taken.push_back(together.status(i).iterations);
    }
    return taken;
  }
};

// What a work group does at once has the bits of a dispatch a step, which as many copies get as are
// not small any more.
TEST_F(EmbedInstances, SmallOnesTakeAllStepsAtOnce) {
  open({.variant = kHardwareVariant});
  // Positions and normals after five steps, and the status.
  const auto five_steps = [&](const PolygonMesh& mesh) {
    const HostTopology topology = topology_of(mesh);
    HostFrame frame = frame_of(topology);
    const std::vector<Vertex> vertices = run(frame, mesh, iterations(5));
    return std::pair(vertices, frame.status());
  };
  for (const PolygonMesh& mesh :
       {test::icosphere(1), test::torus(12, 7, 2, 0.7), test::icosphere(2)}) {
    const std::vector<PolygonMesh> copies(256 / mesh.vertex_count() + 1, mesh);
    auto [vertices, status] = five_steps(mesh);
    auto [many, status_of_many] = five_steps(merged_meshes(copies).mesh);
    EXPECT_EQ(bits_of(status), bits_of(status_of_many));
    // Given points come first.
    ASSERT_GT(many.size(), vertices.size());
    vertices.resize(mesh.positions.size());
    many.resize(mesh.positions.size());
    EXPECT_TRUE(same_bits(vertices, many));
  }
}

TEST_F(EmbedInstances, BitsAreThoseOfSolvesOfTheirOwn) {
  const PolygonMesh meshes[] = {test::icosphere(1), test::torus(12, 7, 2, 0.7),
                                test::with_random_creases(test::random_open_mesh(2), 0.1, 3)};
  with_both_variants([&] {
    for (const PolygonMesh& mesh : meshes) {
      const HostTopology topology = topology_of(mesh);
      HostFrame together = frame_of(topology, {8, 36, 20, 4, 40}, kCount);
      HostFrame frame = frame_of(topology);
      const auto alone = [&](std::uint32_t) -> HostFrame& { return frame; };
      std::fill(together.output.mapped().begin(), together.output.mapped().end(), std::byte{0x5a});
      together.output.flush();
      const std::vector<std::uint32_t> taken =
          expect_same_bits(together, alone, 0, mesh, stopping(40, 1e-4));
      EXPECT_GT(std::set(taken.begin(), taken.end()).size(), 1u);
      EXPECT_LT(*std::max_element(taken.begin(), taken.end()), 40u);
      expect_same_bits(together, alone, 1, mesh, iterations(7));
      // The first stops at once, tests of the error (every fourth step) before the others.
      small_ = 0;
      small_size_ = 1e-6;
      const std::vector<std::uint32_t> late =
          expect_same_bits(together, alone, 2, mesh, stopping(40, 1e-6));
      EXPECT_LE(late[0], 4u);
      EXPECT_GT(*std::max_element(late.begin(), late.end()), 4u);
      small_ = 2;
      small_size_ = 0.02;
      // Bytes between vertices and between instances are left alone.
      for (std::uint32_t i = 0; i < kCount; ++i) {
        const std::byte* first = &together.output.mapped()[8 + i * together.instance_stride()];
        for (const std::uint64_t byte : {0ul, 16ul, 32ul}) EXPECT_EQ(first[byte], std::byte{0x5a});
        EXPECT_EQ(first[together.instance_stride() - 1], std::byte{0x5a});
      }
    }
  });
}

TEST_F(EmbedInstances, WarmStartsAreEachTheirOwn) {
  const PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  const HostTopology topology = topology_of(mesh);
  HostFrame together = frame_of(topology, {}, kCount);
  std::vector<HostFrame> alone;
  for (std::uint32_t i = 0; i < kCount; ++i) alone.push_back(frame_of(topology));
  SolveParameters parameters = stopping(40, 1e-5);
  parameters.warm_start = true;
  submitter_->run([&](VkCommandBuffer commands) {
    together.solve.record_reset(commands);
    for (const HostFrame& frame : alone) frame.solve.record_reset(commands);
  });
  for (int frame = 0; frame < 3; ++frame)
    expect_same_bits(
        together, [&](std::uint32_t i) -> HostFrame& { return alone[i]; }, frame, mesh, parameters);
}

TEST_F(EmbedInstances, ResetAndSolveStandInOneCommandBuffer) {
  const PolygonMesh mesh = test::icosphere(1);
  const HostTopology topology = topology_of(mesh);
  HostFrame fresh = frame_of(topology), used = frame_of(topology);
  SolveParameters warm = iterations(8);
  warm.warm_start = true;
  run(used, posed(mesh, 3), iterations(8));
  for (HostFrame* frame : {&fresh, &used}) {
    frame->set_points(mesh);
    submitter_->run([&](VkCommandBuffer commands) {
      frame->solve.record_reset(commands);
      frame->record(commands, warm);
    });
  }
  EXPECT_EQ(difference(used.vertices(), fresh.vertices()).distance, 0);
}

TEST_F(EmbedInstances, CutTablesGiveTheSameControlPoints) {
  const PolygonMesh mesh = test::torus(24, 14, 2, 0.7);
  const auto control_points = [&](std::uint32_t count, std::uint32_t first) {
    const HostTopology topology = topology_of(mesh, {.level = 0}, {12});
    std::vector<glm::vec3> points;
    for (std::uint32_t i = 0; i < count; ++i)
      for (const glm::dvec3& p : posed(mesh, static_cast<int>(first + i)).positions)
        points.emplace_back(p);
    const Buffer given = filled(*context_, points);
    // Its own points, copied.
    const vulkan::Solve solve(*context_, topology.device, {.instances = count});
    Buffer result(*context_, count * solve.control_point_stride(), MemoryUse::Download);
    submitter_->run([&](VkCommandBuffer commands) {
      solve.record_given(commands, given.handle(), 0);
      solve.record_solve(commands, iterations(20));
      solve.record_surface(commands);
      record_barrier(*context_, commands, kExitScope, kEntryScope);
      const VkBufferCopy copy{0, 0, result.size()};
      context_->vk().vkCmdCopyBuffer(commands, solve.control_points(), result.handle(), 1, &copy);
    });
    std::vector<std::vector<std::uint32_t>> words;  // of each instance
    for (std::uint32_t i = 0; i < count; ++i)
      words.push_back(fetched<std::uint32_t>(result, 4 * mesh.positions.size(),
                                             i * solve.control_point_stride()));
    return std::pair(words, topology.device.slice_count());
  };
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant}) {
    open({.variant = variant});
    std::vector<std::vector<std::uint32_t>> expected = control_points(1, 0).first;
    const auto [second, slices] = control_points(1, 1);
    expected.push_back(second.front());
    PretendedDriver::pretence().storage_range = 22528;
    open({.variant = variant});
    const auto [found, cut_slices] = control_points(2, 0);
    PretendedDriver::pretence() = {};
    EXPECT_GT(cut_slices, slices);
    EXPECT_EQ(found, expected);
  }
}

TEST_F(EmbedInstances, DispatchesAreThoseOfOne) {
  const HostTopology topology = topology_of(test::icosphere(2));
  const HostFrame one = frame_of(topology), all = frame_of(topology, {}, kCount);
  HostCommands commands(*own_);
  const auto calls_of = [&](const HostFrame& frame) {
    return recorded_calls(
        commands, [&](VkCommandBuffer buffer) { frame.record(buffer, stopping(20, 1e-5)); });
  };
  const std::map<std::string, int> calls = calls_of(all);
  EXPECT_EQ(calls, calls_of(one));
  EXPECT_GT(calls.at("vkCmdDispatch"), 5);
}

// 240 points of level 1, of 16 bytes.
TEST_F(EmbedInstances, LimitsAreNamed) {
  PretendedDriver::pretence().storage_range = 16384;
  open();
  const HostTopology small = topology_of(test::icosphere(1), {.level = 0}, {24});
  const Buffer target(*context_, 1 << 20, MemoryUse::Device);
  const VkBuffer buffer = target.handle();
  const auto expect_limit = [&](const std::string& words, const SolveOptions& options) {
    expect_refusal(ErrorCode::OutOfMemory, words,
                   [&] { const vulkan::Solve solve(*context_, small.device, options); });
  };
  expect_limit(
      "points of level 1 of 5 instances take 19200 bytes of one binding, but "
      "maxStorageBufferRange is 16384; make Solves of at most 4 instances",
      {.vertices = {buffer}, .instances = 5});
  const vulkan::Solve solve(*context_, small.device, {.vertices = {buffer}, .instances = 4});
  expect_limit("vertices of 4 instances take",
               {.vertices = {.buffer = buffer, .instance_stride = 8192}, .instances = 4});
  expect_limit("given points of 4 instances take",
               {.given = {buffer, 0, 12, 8192}, .vertices = {buffer}, .instances = 4});
  expect_limit("steps of 4 instances take",
               {.max_iterations = 400, .vertices = {buffer}, .instances = 4});
}

using InstancesWithPlaces = PlacesOnDevice;

TEST_F(InstancesWithPlaces, AreOnTheInstanceAskedFor) {
  const PolygonMesh mesh = in_floats(test::with_random_creases(test::random_open_mesh(2), 0.1, 3));
  const std::vector<PlaceRecord> places = places_on(MeshTopology(mesh), 1, 2);
  const auto count = static_cast<std::uint32_t>(places.size());
  with_both_variants([&] {
    Case c(*context_, *submitter_, mesh, {}, {.list = {.count = count}});
    put(c.list, places);
    std::vector<glm::vec3> points;
    for (int i = 0; i < 3; ++i)
      for (const glm::vec3& p : points_of(posed(mesh, i))) points.push_back(p);
    const Buffer given = filled(*context_, points);
    const vulkan::Solve solve(*context_, c.tables, {.given = {given.handle()}, .instances = 3});
    const auto options_on = [&](std::uint32_t i) {
      return PlacesOptions{{c.list.handle(), 0, 12, count}, {.buffer = c.results.handle()}, i};
    };
    const auto results_on = [&](const vulkan::Solve& of, std::uint32_t i) {
      const Places asked(*context_, c.tables, of, options_on(i));
      submitter_->run([&](VkCommandBuffer commands) {
        of.record_solve(commands, {});
        of.record_surface(commands);
        asked.record_evaluate(commands);
      });
      return fetched<std::byte>(c.results, c.results.mapped().size());
    };
    for (std::uint32_t i = 0; i < 3; ++i) {
      put(c.points, points_of(posed(mesh, static_cast<int>(i))));
      EXPECT_EQ(results_on(solve, i), results_on(c.solve, 0)) << i;
    }
    EXPECT_NE(results_on(solve, 0), results_on(solve, 1));
    EXPECT_THROW(Places(*context_, c.tables, solve, options_on(3)), Error);
  });
}

// Several meshes in one command buffer: the same bits as one by one, with the barriers of one.

// One mesh with its tables and two frames: one recorded by itself, one beside others.
struct Twin {
  Twin(Context& context, Submitter& submitter, PolygonMesh rest, const SystemOptions& options,
       const SolveParameters& wanted)
      : mesh(std::move(rest)),
        topology(context, submitter, mesh, options, {24}),
        alone(context, topology),
        beside(context, topology),
        parameters(wanted) {}

  PolygonMesh mesh;
  HostTopology topology;
  HostFrame alone, beside;
  SolveParameters parameters;
};

class EmbedMany : public Embedding {
 protected:
  void add(const PolygonMesh& mesh, const SystemOptions& options = {},
           const SolveParameters& parameters = iterations(20)) {
    twins_.emplace_back(*context_, *submitter_, mesh, options, parameters);
  }

  // Closed and open, with creases, fair, stopped early, and with other counts of iterations.
  void add_all(bool small) {
    const SystemOptions fair{.method = InterpolationMethod::Fair}, flat{.level = 0};
    const SolveParameters stopped = stopping(40, 1e-4);
    add(test::icosphere(1), {.level = 1}, stopped);
    add(test::torus(12, 7, 2, 0.7), {.level = 1}, {.iterations = 3});
    add(test::cube(), flat, iterations(0));
    add(test::icosphere(0), fair);
    if (small) return;
    SolveParameters warm = stopped;
    warm.warm_start = true;
    add(test::with_random_creases(test::random_open_mesh(2), 0.1, 3), {}, warm);
    add(test::random_closed_mesh(4), flat, iterations(13));
    add(test::jittered(test::icosphere(2), 0.5, 1), fair);
  }

  std::vector<SolveCall> solves() const {
    std::vector<SolveCall> calls;
    for (const Twin& twin : twins_) calls.push_back({&twin.beside.solve, twin.parameters});
    return calls;
  }
  std::vector<EvaluateCall> evaluations() const {
    std::vector<EvaluateCall> calls;
    for (const Twin& twin : twins_) calls.push_back({&twin.beside.solve, {}});
    return calls;
  }

  void expect_same_bits(int pose) {
    for (Twin& twin : twins_) {
      run(twin.alone, posed(twin.mesh, pose), twin.parameters);
      twin.beside.set_points(posed(twin.mesh, pose));
    }
    submitter_->run([&](VkCommandBuffer commands) {
      record_solves(commands, solves());
      record_evaluates(commands, evaluations());
      for (const Twin& twin : twins_)
        twin.beside.solve.record_status(commands, twin.beside.report.handle(), 0);
    });
    for (Twin& twin : twins_) {
      EXPECT_TRUE(same_bits(twin.beside.vertices(), twin.alone.vertices()));
      EXPECT_EQ(bits_of(twin.beside.status()), bits_of(twin.alone.status()));
    }
  }

  void clear_displacements() {
    submitter_->run([&](VkCommandBuffer commands) {
      for (const Twin& twin : twins_)
        for (const HostFrame* frame : {&twin.alone, &twin.beside})
          frame->solve.record_reset(commands);
    });
  }

  void TearDown() override {
    twins_.clear();
    Embedding::TearDown();
  }

  std::deque<Twin> twins_;
};

TEST_F(EmbedMany, ResultsAreTheBitsOfOneByOne) {
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant}) {
    twins_.clear();
    open({.variant = variant});
    add_all(/*small=*/false);
    clear_displacements();
    for (const int pose : {0, 1}) expect_same_bits(pose);
    const GpuStatus stopped = twins_.front().beside.status();
    EXPECT_EQ(stopped.state, SolveState::Converged);
    EXPECT_LT(stopped.iterations, 40u);
    // And they are surfaces.
    Twin& flat = twins_[5];
    EXPECT_LT(difference(flat.beside.vertices(),
                         surface_by_cpu(posed(flat.mesh, 1), flat.mesh, {.level = 0}))
                  .distance,
              4e-6);
  }
}

TEST_F(EmbedMany, SlicesOfDifferentCountsGoTogether) {
  PretendedDriver::pretence().storage_range = 8192;
  open();
  add_all(/*small=*/true);
  clear_displacements();
  EXPECT_GT(twins_[1].topology.device.slice_count(), twins_[2].topology.device.slice_count());
  expect_same_bits(3);
}

TEST_F(EmbedMany, BarriersAreThoseOfOne) {
  const PolygonMesh mesh = test::icosphere(3);  // more points than one work group takes at once
  for (int i = 0; i < 5; ++i) add(mesh, {}, stopping(20, 1e-5));
  HostCommands commands(*own_);
  struct Calls {
    int barriers, dispatches;
  };
  const auto calls_of = [&](const std::function<void(VkCommandBuffer)>& record) {
    std::map<std::string, int> calls = recorded_calls(commands, record);
    return Calls{calls["vkCmdPipelineBarrier"],
                 calls["vkCmdDispatch"] + calls["vkCmdDispatchIndirect"]};
  };
  const std::vector<SolveCall> all = solves();
  const std::vector<EvaluateCall> evaluated = evaluations();
  const Calls none = calls_of([&](VkCommandBuffer buffer) {
    record_solves(buffer, {});
    record_evaluates(buffer, {});
  });
  EXPECT_EQ(none.barriers, 0);
  EXPECT_EQ(none.dispatches, 0);
  const Calls one = calls_of([&](VkCommandBuffer buffer) {
    all[0].solve->record_solve(buffer, all[0].parameters);
    all[0].solve->record_evaluate(buffer);
  });
  const Calls five = calls_of([&](VkCommandBuffer buffer) {
    record_solves(buffer, all);
    record_evaluates(buffer, evaluated);
  });
  EXPECT_GT(one.barriers, 25);
  EXPECT_EQ(five.barriers, one.barriers);
  EXPECT_EQ(five.dispatches, 5 * one.dispatches);
}

}  // namespace
}  // namespace planish::testing
