#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
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
using ::testing::HasSubstr;

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

  /// A frame of all instances in one Solve and of each by itself; returns their iterations.
  std::vector<std::uint32_t> expect_same_bits(HostFrame& together, HostFrame& alone, int frame,
                                              const PolygonMesh& rest,
                                              const SolveParameters& parameters) {
    for (std::uint32_t i = 0; i < kCount; ++i) together.set_points(pose_of(rest, frame, i), i);
    submitter_->run([&](VkCommandBuffer commands) { together.record(commands, parameters); });
    std::vector<std::uint32_t> taken;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const std::vector<Vertex> expected = run(alone, pose_of(rest, frame, i), parameters);
      const std::vector<Vertex> found = together.vertices(i);
      EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof(Vertex)), 0) << i;
      const GpuStatus status = together.status(i), wanted = alone.status();
      EXPECT_EQ(bits_of(status), bits_of(wanted))
          << i << ": " << status.iterations << " and " << wanted.iterations << " iterations";
      taken.push_back(status.iterations);
    }
    return taken;
  }

  // Positions and normals after five steps, and the status.
  std::pair<std::vector<Vertex>, GpuStatus> five_steps(const PolygonMesh& mesh) {
    HostTopology topology(*context_, mesh);
    topology.upload(*submitter_);
    HostFrame frame(*context_, topology);
    std::vector<Vertex> vertices = run(frame, mesh, iterations(5));
    return {std::move(vertices), frame.status()};
  }

  void expect_refusal(const DeviceSystem& tables, const SolveOptions& options, ErrorCode code,
                      const std::string& words) {
    const std::map<std::string, int> before = PretendedDriver::alive();
    try {
      const vulkan::Solve solve(*context_, tables, options);
      ADD_FAILURE() << "nothing thrown: " << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_THAT(error.what(), HasSubstr(words));
    }
    EXPECT_EQ(PretendedDriver::alive(), before);
  }
};

// What a work group does at once has the bits of a dispatch a step, which as many copies get as are
// not small any more.
TEST_F(EmbedInstances, SmallOnesTakeAllStepsAtOnce) {
  open({.variant = kHardwareVariant});
  for (const PolygonMesh& mesh :
       {test::icosphere(1), test::torus(12, 7, 2, 0.7), test::icosphere(2)}) {
    std::vector<PolygonMesh> copies(256 / mesh.vertex_count() + 1, mesh);
    const auto [vertices, status] = five_steps(mesh);
    const auto [many, status_of_many] = five_steps(merged_meshes(copies).mesh);
    EXPECT_EQ(status.iterations, status_of_many.iterations);
    EXPECT_EQ(bits_of(status), bits_of(status_of_many));
    // Given points come first.
    ASSERT_GT(many.size(), vertices.size());
    for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
      ASSERT_EQ(std::memcmp(&vertices[v], &many[v], sizeof(Vertex)), 0) << v;
  }
}

TEST_F(EmbedInstances, BitsAreThoseOfSolvesOfTheirOwn) {
  const PolygonMesh meshes[] = {test::icosphere(1), test::torus(12, 7, 2, 0.7),
                                test::with_random_creases(test::random_open_mesh(2), 0.1, 3)};
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant}) {
    ContextOptions options;
    options.variant = variant;
    open(options);
    for (const PolygonMesh& mesh : meshes) {
      HostTopology topology(*context_, mesh);
      topology.upload(*submitter_);
      HostFrame together(*context_, topology, {8, 36, 20, 4, 40}, 64, kCount);
      HostFrame alone(*context_, topology);
      std::fill(together.output.mapped().begin(), together.output.mapped().end(), std::byte{0x5a});
      together.output.flush();
      SolveParameters stopped = iterations(40);
      stopped.stop_error = 1e-4f;
      const std::vector<std::uint32_t> taken = expect_same_bits(together, alone, 0, mesh, stopped);
      EXPECT_GT(std::set(taken.begin(), taken.end()).size(), 1u);
      EXPECT_LT(*std::max_element(taken.begin(), taken.end()), 40u);
      expect_same_bits(together, alone, 1, mesh, iterations(7));
      // The first stops at once, tests of the error (every fourth step) before the others.
      small_ = 0;
      small_size_ = 1e-6;
      stopped.stop_error = 1e-6f;
      const std::vector<std::uint32_t> late = expect_same_bits(together, alone, 2, mesh, stopped);
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
  }
}

TEST_F(EmbedInstances, WarmStartsAreEachTheirOwn) {
  const PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  HostFrame together(*context_, topology, {}, 64, kCount);
  std::vector<std::unique_ptr<HostFrame>> alone;
  for (std::uint32_t i = 0; i < kCount; ++i)
    alone.push_back(std::make_unique<HostFrame>(*context_, topology));
  SolveParameters parameters = iterations(40);
  parameters.stop_error = 1e-5f;
  parameters.warm_start = true;
  submitter_->run([&](VkCommandBuffer commands) {
    together.solve.record_reset(commands);
    for (const auto& frame : alone) frame->solve.record_reset(commands);
  });
  for (int frame = 0; frame < 3; ++frame) {
    for (std::uint32_t i = 0; i < kCount; ++i) together.set_points(pose_of(mesh, frame, i), i);
    submitter_->run([&](VkCommandBuffer commands) { together.record(commands, parameters); });
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const std::vector<Vertex> expected = run(*alone[i], pose_of(mesh, frame, i), parameters);
      const std::vector<Vertex> found = together.vertices(i);
      EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof(Vertex)), 0)
          << frame << ", " << i;
      EXPECT_EQ(together.status(i).iterations, alone[i]->status().iterations);
    }
  }
}

TEST_F(EmbedInstances, ResetAndSolveStandInOneCommandBuffer) {
  const PolygonMesh mesh = test::icosphere(1);
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  HostFrame fresh(*context_, topology), used(*context_, topology);
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
    HostTopology topology(*context_, mesh, {.level = 0}, 12);
    topology.upload(*submitter_);
    Buffer given(*context_, count * mesh.positions.size() * sizeof(glm::vec3), MemoryUse::Upload);
    std::vector<glm::vec3> points;
    for (std::uint32_t i = 0; i < count; ++i)
      for (const glm::dvec3& p : posed(mesh, static_cast<int>(first + i)).positions)
        points.emplace_back(p);
    std::memcpy(given.mapped().data(), points.data(), points.size() * sizeof points[0]);
    given.flush();
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
    result.invalidate();
    std::vector<glm::vec4> all;
    for (std::uint32_t i = 0; i < count; ++i) {
      std::vector<glm::vec4> some(mesh.positions.size());
      std::memcpy(some.data(), &result.mapped()[i * solve.control_point_stride()],
                  some.size() * sizeof some[0]);
      all.insert(all.end(), some.begin(), some.end());
    }
    return std::pair(all, topology.device.slice_count());
  };
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant}) {
    ContextOptions options;
    options.variant = variant;
    open(options);
    std::vector<glm::vec4> expected = control_points(1, 0).first;
    const auto [second, slices] = control_points(1, 1);
    expected.insert(expected.end(), second.begin(), second.end());
    PretendedDriver::pretence().storage_range = 22528;
    open(options);
    const auto [found, cut_slices] = control_points(2, 0);
    PretendedDriver::pretence() = {};
    EXPECT_GT(cut_slices, slices);
    ASSERT_EQ(found.size(), expected.size());
    EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof found[0]), 0);
  }
}

TEST_F(EmbedInstances, DispatchesAreThoseOfOne) {
  HostTopology topology(*context_, test::icosphere(2));
  topology.upload(*submitter_);
  const HostFrame one(*context_, topology), all(*context_, topology, {}, 64, kCount);
  SolveParameters stopped = iterations(20);
  stopped.stop_error = 1e-5f;
  const auto calls_of = [&](const HostFrame& frame) {
    std::map<std::string, int> since;
    HostCommands commands(*own_);
    commands.record([&](VkCommandBuffer buffer) {
      const std::map<std::string, int> before = PretendedDriver::counts();
      frame.record(buffer, stopped);
      for (const auto& [name, count] : PretendedDriver::counts()) {
        const auto found = before.find(name);
        const int more = count - (found == before.end() ? 0 : found->second);
        if (more > 0) since[name] = more;
      }
    });
    return since;
  };
  const std::map<std::string, int> calls = calls_of(all);
  EXPECT_EQ(calls, calls_of(one));
  EXPECT_GT(calls.at("vkCmdDispatch"), 5);
  for (const auto& [name, count] : calls) EXPECT_THAT(name, ::testing::StartsWith("vkCmd"));
}

TEST_F(EmbedInstances, WrongOptionsAreRefusedByName) {
  const PolygonMesh mesh = test::icosphere(1);
  HostTopology topology(*context_, mesh),
      fair(*context_, mesh, {.method = InterpolationMethod::Fair});
  const Buffer vertices(*context_, 1 << 20, MemoryUse::Device);
  SolveOptions options;
  options.vertices.buffer = vertices.handle();
  for (const std::uint32_t count : {0u, 65536u}) {
    options.instances = count;
    expect_refusal(topology.device, options, ErrorCode::InvalidArgument,
                   "instances " + std::to_string(count) + " are outside 1 to 65535");
  }
  options.instances = 2;
  expect_refusal(fair.device, options, ErrorCode::InvalidArgument, "record_solves()");
  options.vertices.instance_stride = topology.device.vertex_count() * 24 - 4;
  expect_refusal(topology.device, options, ErrorCode::InvalidArgument,
                 "vertices of an instance take");
  options.vertices.instance_stride += 2;
  expect_refusal(topology.device, options, ErrorCode::InvalidArgument, "multiples of 4 bytes");
}

TEST_F(EmbedInstances, LimitsAreNamed) {
  PretendedDriver::pretence().storage_range = 16384;
  open();
  const PolygonMesh mesh = test::icosphere(1);
  SolveOptions options;
  const HostTopology small(*context_, mesh, {.level = 0}, 24);
  const Buffer target(*context_, 1 << 20, MemoryUse::Device);
  options.vertices.buffer = target.handle();
  // 240 points of level 1, of 16 bytes.
  options.instances = 5;
  expect_refusal(small.device, options, ErrorCode::OutOfMemory,
                 "points of level 1 of 5 instances take 19200 bytes of one binding, but "
                 "maxStorageBufferRange is 16384; make Solves of at most 4 instances");
  options.instances = 4;
  const vulkan::Solve solve(*context_, small.device, options);
  options.vertices.instance_stride = 8192;
  expect_refusal(small.device, options, ErrorCode::OutOfMemory, "vertices of 4 instances take");
  options.vertices.instance_stride = 0;
  options.given = {target.handle(), 0, 12, 8192};
  expect_refusal(small.device, options, ErrorCode::OutOfMemory, "given points of 4 instances take");
  options.given = {};
  options.max_iterations = 400;
  expect_refusal(small.device, options, ErrorCode::OutOfMemory, "steps of 4 instances take");
}

using InstancesWithPlaces = PlacesOnDevice;

TEST_F(InstancesWithPlaces, AreOnTheInstanceAskedFor) {
  const PolygonMesh mesh = in_floats(test::with_random_creases(test::random_open_mesh(2), 0.1, 3));
  const std::vector<PlaceRecord> places = places_on(MeshTopology(mesh), 1, 2);
  const auto count = static_cast<std::uint32_t>(places.size());
  for (const ReadPath path : {ReadPath::Texel, ReadPath::Storage}) {
    open_reading(path);
    Case c(*context_, *submitter_, mesh, {}, {.list = {.count = count}});
    std::memcpy(c.list.mapped().data(), places.data(), places.size() * sizeof places[0]);
    c.list.flush();
    Buffer given(*context_, 3 * mesh.positions.size() * sizeof(glm::vec3), MemoryUse::Upload);
    for (std::uint32_t i = 0; i < 3; ++i) {
      const PolygonMesh pose = posed(mesh, static_cast<int>(i));
      const std::vector<glm::vec3> rounded(pose.positions.begin(), pose.positions.end());
      const std::size_t bytes = rounded.size() * sizeof rounded[0];
      std::memcpy(given.mapped().data() + i * bytes, rounded.data(), bytes);
    }
    given.flush();
    const vulkan::Solve solve(*context_, c.tables, {.given = {given.handle()}, .instances = 3});
    const auto results_on = [&](const vulkan::Solve& of, std::uint32_t i) {
      const Places asked(*context_, c.tables, of,
                         {{c.list.handle(), 0, 12, count}, {.buffer = c.results.handle()}, i});
      submitter_->run([&](VkCommandBuffer commands) {
        of.record_solve(commands, {});
        of.record_surface(commands);
        asked.record_evaluate(commands);
      });
      c.results.invalidate();
      return std::vector<std::byte>(c.results.mapped().begin(), c.results.mapped().end());
    };
    const std::size_t bytes = mesh.positions.size() * sizeof(glm::vec3);
    for (std::uint32_t i = 0; i < 3; ++i) {
      std::memcpy(c.points.mapped().data(), given.mapped().data() + i * bytes, bytes);
      c.points.flush();
      EXPECT_EQ(results_on(solve, i), results_on(c.solve, 0)) << i;
    }
    EXPECT_NE(results_on(solve, 0), results_on(solve, 1));
    EXPECT_THROW(Places(*context_, c.tables, solve,
                        {{c.list.handle(), 0, 12, count}, {.buffer = c.results.handle()}, 3}),
                 Error);
  }
}

// Several meshes in one command buffer: the same bits as one by one, with the barriers of one.

// One mesh with its tables and two frames: one recorded by itself, one beside others.
struct Twin {
  Twin(Context& context, PolygonMesh rest, const SystemOptions& options,
       const SolveParameters& wanted)
      : mesh(std::move(rest)),
        topology(context, mesh, options, 24),
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
  Twin& add(const PolygonMesh& mesh, const SystemOptions& options = {},
            const SolveParameters& parameters = iterations(20)) {
    twins_.push_back(std::make_unique<Twin>(*context_, mesh, options, parameters));
    twins_.back()->topology.upload(*submitter_);
    return *twins_.back();
  }

  // Closed and open, with creases, fair, stopped early, and with other counts of iterations.
  void add_all(bool small) {
    SystemOptions fair, flat, coarse;
    fair.method = InterpolationMethod::Fair;
    flat.level = 0;
    coarse.level = 1;
    SolveParameters stopped = iterations(40), few = iterations(3);
    stopped.stop_error = 1e-4f;
    few.measures_last = false;
    add(test::icosphere(1), coarse, stopped);
    add(test::torus(12, 7, 2, 0.7), coarse, few);
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
    for (const auto& twin : twins_) calls.push_back({&twin->beside.solve, twin->parameters});
    return calls;
  }
  std::vector<EvaluateCall> evaluations() const {
    std::vector<EvaluateCall> calls;
    for (const auto& twin : twins_) calls.push_back({&twin->beside.solve, {}});
    return calls;
  }

  void expect_same_bits(int pose) {
    for (const auto& twin : twins_) {
      for (HostFrame* frame : {&twin->alone, &twin->beside})
        frame->set_points(posed(twin->mesh, pose));
      submitter_->run(
          [&](VkCommandBuffer commands) { twin->alone.record(commands, twin->parameters); });
    }
    submitter_->run([&](VkCommandBuffer commands) {
      record_solves(commands, solves());
      record_evaluates(commands, evaluations());
      for (const auto& twin : twins_)
        twin->beside.solve.record_status(commands, twin->beside.report.handle(), 0);
    });
    for (std::size_t i = 0; i < twins_.size(); ++i) {
      const std::vector<Vertex> expected = twins_[i]->alone.vertices();
      const std::vector<Vertex> found = twins_[i]->beside.vertices();
      ASSERT_EQ(found.size(), expected.size());
      EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof(Vertex)), 0) << i;
      const GpuStatus status = twins_[i]->beside.status(), wanted = twins_[i]->alone.status();
      EXPECT_EQ(bits_of(status), bits_of(wanted))
          << i << ": " << status.iterations << " and " << wanted.iterations << " iterations";
    }
  }

  void clear_displacements() {
    submitter_->run([&](VkCommandBuffer commands) {
      for (const auto& twin : twins_)
        for (HostFrame* frame : {&twin->alone, &twin->beside}) frame->solve.record_reset(commands);
    });
  }

  void TearDown() override {
    twins_.clear();
    Embedding::TearDown();
  }

  std::vector<std::unique_ptr<Twin>> twins_;
};

TEST_F(EmbedMany, ResultsAreTheBitsOfOneByOne) {
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant}) {
    ContextOptions options;
    options.variant = variant;
    twins_.clear();
    open(options);
    add_all(/*small=*/false);
    clear_displacements();
    for (const int pose : {0, 1}) expect_same_bits(pose);
    const GpuStatus stopped = twins_.front()->beside.status();
    EXPECT_EQ(stopped.state, SolveState::Converged);
    EXPECT_LT(stopped.iterations, 40u);
    // And they are surfaces.
    const Twin& torus = *twins_[5];
    SystemOptions flat;
    flat.level = 0;
    EXPECT_LT(difference(twins_[5]->beside.vertices(),
                         surface_by_cpu(posed(torus.mesh, 1), torus.mesh, flat))
                  .distance,
              4e-6);
  }
}

TEST_F(EmbedMany, SlicesOfDifferentCountsGoTogether) {
  PretendedDriver::pretence().storage_range = 8192;
  open();
  add_all(/*small=*/true);
  clear_displacements();
  EXPECT_GT(twins_[1]->topology.device.slice_count(), twins_[2]->topology.device.slice_count());
  expect_same_bits(3);
}

TEST_F(EmbedMany, BarriersAreThoseOfOne) {
  SolveParameters stopped = iterations(20);
  stopped.stop_error = 1e-5f;
  const PolygonMesh mesh = test::icosphere(3);  // more points than one work group takes at once
  for (int i = 0; i < 5; ++i) add(mesh, {}, stopped);
  struct Calls {
    int barriers, dispatches;
  };
  const auto calls_of = [&](const std::function<void(VkCommandBuffer)>& record) {
    const auto total = [] {
      return Calls{PretendedDriver::count("vkCmdPipelineBarrier"),
                   PretendedDriver::count("vkCmdDispatch") +
                       PretendedDriver::count("vkCmdDispatchIndirect")};
    };
    Calls since{};
    HostCommands commands(*own_);
    commands.record([&](VkCommandBuffer buffer) {
      const std::map<std::string, int> counts = PretendedDriver::counts();
      const Calls before = total();
      record(buffer);
      since = {total().barriers - before.barriers, total().dispatches - before.dispatches};
      for (const auto& [name, count] : PretendedDriver::counts()) {
        const auto found = counts.find(name);
        if (found == counts.end() || found->second != count) {
          EXPECT_THAT(name, ::testing::StartsWith("vkCmd"));
        }
      }
    });
    return since;
  };
  const std::vector<SolveCall> all = solves();
  const std::vector<EvaluateCall> evaluated = evaluations();
  const Calls none = calls_of([&](VkCommandBuffer commands) {
    record_solves(commands, {});
    record_evaluates(commands, {});
  });
  EXPECT_EQ(none.barriers, 0);
  EXPECT_EQ(none.dispatches, 0);
  const Calls one = calls_of([&](VkCommandBuffer commands) {
    all[0].solve->record_solve(commands, all[0].parameters);
    all[0].solve->record_evaluate(commands);
  });
  const Calls five = calls_of([&](VkCommandBuffer commands) {
    record_solves(commands, all);
    record_evaluates(commands, evaluated);
  });
  EXPECT_GT(one.barriers, 25);
  EXPECT_EQ(five.barriers, one.barriers);
  EXPECT_EQ(five.dispatches, 5 * one.dispatches);
}

}  // namespace
}  // namespace planish::testing
