#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <thread>

#include "planish/mesh/face_geometry.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/surface_blocks.h"
#include "planish/vulkan/device/driver.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

// Surfaces made in a host's command buffers, against fit() and evaluate() on the CPU.

using namespace vulkan;

// Single precision of coordinates of a few units, through a solve and a chain of levels.
constexpr double kEmbedDistance = 4e-6;
constexpr double kCosine = 1 - 1e-5;

// Meshes whose vertices, faces, boundaries and creases differ most.
std::vector<test::NamedMesh> mixed_meshes() {
  const PolygonMesh torus = test::torus(9, 6, 2, 0.7);
  PolygonMesh holed = torus;
  holed.hole_faces = {3, 17};
  return {{"icosphere", test::icosphere(2)},
          {"torus", test::torus(12, 7, 2, 0.7)},
          {"random", test::random_closed_mesh(3)},
          {"open", test::random_open_mesh(4)},
          {"creases", test::with_random_creases(test::random_open_mesh(5), 0.15, 6)},
          {"unused vertex", with_unused(torus, 20, {100, 0, 0})},
          {"holes", holed},
          // Given points are read from the first used vertex on.
          {"unused vertices first", with_unused(torus, 0, {0, 100, 0}, 7)}};
}

TEST_F(Embedding, SurfaceEqualsTheCpus) {
  for (const test::NamedMesh& mesh : mixed_meshes())
    for (const int level : {0, 1, 2}) {
      SCOPED_TRACE(mesh.name + " " + std::to_string(level));
      const HostTopology topology = topology_of(mesh.mesh, {.level = level});
      HostFrame frame = frame_of(topology);
      const PolygonMesh pose = posed(mesh.mesh, 1);
      const Difference off = difference(run(frame, pose, iterations(40)),
                                        surface_by_cpu(pose, mesh.mesh, {.level = level}));
      EXPECT_LT(off.distance, kEmbedDistance);
      EXPECT_GT(off.cosine, kCosine);
      EXPECT_EQ(frame.status().iterations, 40u);
      EXPECT_EQ(frame.status().state, SolveState::Stepped);
      EXPECT_LT(frame.status().residual, 2e-6);
    }
}

TEST_F(Embedding, IndicesAreTheCpuSurfaces) {
  for (const test::NamedMesh& mesh : mixed_meshes())
    for (const int level : {0, 2}) {
      SCOPED_TRACE(mesh.name + " " + std::to_string(level));
      HostTopology topology = topology_of(mesh.mesh, {.level = level});
      // A host keeps the vertices that only holes name.
      const PolygonMesh whole = without_holes(mesh.mesh);
      const auto backend = make_cpu_backend();
      const SurfaceMesh surface = evaluate(whole, fit(whole, *backend), *backend, {.level = level});
      std::vector<std::int32_t> ancestors(static_cast<std::size_t>(surface.face_count()));
      blocks_of(surface, whole)->ancestors({0, surface.face_count()}, ancestors);
      std::vector<std::uint32_t> expected, quads;
      for (std::int64_t f = 0; f < surface.face_count(); ++f) {
        const auto& holes = mesh.mesh.hole_faces;
        if (std::find(holes.begin(), holes.end(), ancestors[f]) != holes.end()) continue;
        const auto face = surface.face(f);
        quads.insert(quads.end(), face.begin(), face.end());
        expected.resize(expected.size() + 3 * (face.size() - 2));
        triangulate(face, surface.positions, std::span(expected).last(3 * (face.size() - 2)));
      }
      EXPECT_EQ(fetched<std::uint32_t>(topology.indices, topology.device.index_count()), expected);
      if (level > 0) {
        EXPECT_TRUE(std::ranges::equal(topology.system.quads(), quads));
      }
    }
}

TEST_F(Embedding, WritesTheHostsLayoutAndNothingBeside) {
  const PolygonMesh mesh = test::icosphere(1);
  const HostTopology topology = topology_of(mesh);
  HostFrame tight = frame_of(topology);
  const std::vector<Vertex> expected = run(tight, mesh, iterations(20));
  // Normals before positions, at an offset that no device takes as a binding's.
  for (const Layout& layout : {Layout{52, 40, 16, 0}, Layout{4, 64, 0, 52}, Layout{0, 24, 12, 0}}) {
    HostFrame frame = frame_of(topology, layout);
    std::memset(frame.output.mapped().data(), 0x5a, frame.output.mapped().size());
    frame.output.flush();
    EXPECT_TRUE(same_bits(run(frame, mesh, iterations(20)), expected));
    for (std::size_t i = 0; i < expected.size(); ++i) {
      std::byte* vertex = &frame.output.mapped()[layout.offset + i * layout.stride];
      std::memset(vertex + layout.position_offset, 0x5a, sizeof(glm::vec3));
      std::memset(vertex + layout.normal_offset, 0x5a, sizeof(glm::vec3));
    }
    EXPECT_THAT(frame.output.mapped(), ::testing::Each(std::byte{0x5a}));
  }
}

TEST_F(Embedding, TakesPointsOfAnyStrideAndFromStaging) {
  const PolygonMesh mesh = mixed_meshes()[5].mesh;  // with an unused vertex
  const HostTopology topology = topology_of(mesh);
  HostFrame tight = frame_of(topology);
  const std::vector<Vertex> expected = run(tight, mesh, iterations(20));
  const std::vector<glm::vec3> points = points_of(mesh);
  Buffer strided(*context_, 20 + 32 * points.size(), MemoryUse::Upload);
  Buffer staging(*context_, 8 + 12 * points.size(), MemoryUse::Upload);
  put(staging, points, 8);
  for (std::size_t i = 0; i < points.size(); ++i)
    put(strided, std::span(&points[i], 1), 20 + 32 * i);
  const VertexLayout vertices{.buffer = tight.output.handle()};
  const vulkan::Solve staged(*context_, topology.device, {.vertices = vertices}),
      direct(*context_, topology.device,
             {.given = {strided.handle(), 20, 32}, .vertices = vertices});
  for (const vulkan::Solve* solve : {&staged, &direct}) {
    std::memset(tight.output.mapped().data(), 0, tight.output.mapped().size());
    submitter_->run([&](VkCommandBuffer commands) {
      if (solve == &staged) solve->record_given(commands, staging.handle(), 8);
      solve->record_solve(commands, iterations(20));
      solve->record_evaluate(commands);
    });
    EXPECT_TRUE(same_bits(tight.vertices(), expected));
  }
}

TEST_F(Embedding, StopsOnTheDeviceAtTheStepThatTheSystemCounted) {
  const PolygonMesh mesh = test::random_closed_mesh(3);
  const HostTopology topology = topology_of(mesh, {.tolerance = 1e-4});
  const std::uint32_t needed = topology.system.rest_iterations();
  ASSERT_GT(needed, 5u);  // so that indirect dispatches are both done and left out
  HostFrame frame = frame_of(topology);
  const SolveParameters parameters = stopping(60, topology.system.tolerance());
  const std::vector<Vertex> stopped = run(frame, mesh, parameters);
  EXPECT_EQ(frame.status().iterations, needed);
  EXPECT_EQ(frame.status().state, SolveState::Converged);
  EXPECT_LE(frame.status().residual, parameters.stop_error);
  const std::vector<Vertex> counted = run(frame, mesh, iterations(needed));
  EXPECT_EQ(frame.status().state, SolveState::Stepped);
  EXPECT_EQ(frame.status().iterations, needed);
  EXPECT_TRUE(same_bits(stopped, counted));
  // One step less does not suffice.
  static_cast<void>(run(frame, mesh, iterations(needed - 1)));
  EXPECT_GT(frame.status().residual, parameters.stop_error);
}

TEST_F(Embedding, StatusTellsTheErrorThatTheStepsLeave) {
  const PolygonMesh mesh = test::icosphere(2);
  const HostTopology topology = topology_of(mesh);
  HostFrame frame = frame_of(topology);
  static_cast<void>(run(frame, mesh, iterations(0)));
  EXPECT_NEAR(frame.status().residual, topology.system.rest_error(), 1e-6);
  for (const std::uint32_t count : {0u, 1u, 2u, 3u, 6u}) {
    const std::vector<Vertex> found = run(frame, mesh, iterations(count));
    double largest = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
      largest =
          std::max<double>(largest, glm::distance(glm::vec3(mesh.positions[v]), found[v].position));
    EXPECT_NEAR(frame.status().residual, largest, 1e-6) << count;
    const float after = frame.status().residual;
    static_cast<void>(run(frame, mesh, {.iterations = count}));
    EXPECT_EQ(frame.status().iterations, count);
    // Without any step there is nothing before the last.
    EXPECT_EQ(frame.status().residual == after, count == 0) << count;
    EXPECT_GE(frame.status().residual, after) << count;
  }
}

TEST_F(Embedding, WarmStartsNeedFewerIterations) {
  const PolygonMesh mesh = test::torus(14, 9, 2, 0.7);
  const HostTopology topology = topology_of(mesh);
  HostFrame warm(*context_, topology), cold(*context_, topology);
  SolveParameters parameters = stopping(64, 3e-6);
  submitter_->run([&](VkCommandBuffer commands) { warm.solve.record_reset(commands); });
  std::uint32_t warm_total = 0, cold_total = 0;
  for (int frame = 0; frame < 6; ++frame) {
    PolygonMesh pose = mesh;
    for (glm::dvec3& p : pose.positions) p.z += 0.002 * frame * std::sin(p.x);
    parameters.warm_start = true;
    const std::vector<Vertex> by_warm = run(warm, pose, parameters);
    EXPECT_EQ(warm.status().state, SolveState::Converged) << frame;
    warm_total += warm.status().iterations;
    parameters.warm_start = false;
    const std::vector<Vertex> by_cold = run(cold, pose, parameters);
    cold_total += cold.status().iterations;
    // The first frame starts from nothing either way.
    EXPECT_EQ(warm.status().iterations == cold.status().iterations, frame == 0) << frame;
    EXPECT_LT(difference(by_warm, by_cold).distance, 2 * 3e-6) << frame;
  }
  EXPECT_LT(warm_total, 0.7 * cold_total);
}

TEST_F(Embedding, RecoversFromAFrameWithoutNumbers) {
  const PolygonMesh mesh = test::icosphere(1);
  const HostTopology topology = topology_of(mesh);
  HostFrame frame = frame_of(topology);
  const std::vector<Vertex> expected = run(frame, mesh, iterations(20));
  PolygonMesh broken = mesh;
  broken.positions[7].y = std::numeric_limits<double>::quiet_NaN();
  static_cast<void>(run(frame, broken, stopping(20, 1e-6)));
  EXPECT_EQ(frame.status().state, SolveState::NotFinite);
  EXPECT_EQ(frame.status().residual, std::numeric_limits<float>::infinity());
  SolveParameters warm = iterations(40);
  warm.warm_start = true;
  EXPECT_LT(difference(run(frame, mesh, warm), expected).distance, kEmbedDistance);
}

TEST_F(Embedding, WrongSolvesAreRefusedByName) {
  const PolygonMesh mesh = test::icosphere(1);
  const HostTopology topology = topology_of(mesh),
                     fair = topology_of(mesh, {.method = InterpolationMethod::Fair});
  const Buffer all(*context_, 1 << 20, MemoryUse::Device);
  const VkBuffer buffer = all.handle();
  const VkDeviceSize bytes = 24 * VkDeviceSize(topology.device.vertex_count());
  const auto instances = [&](VkDeviceSize stride) {
    return SolveOptions{.vertices = {.buffer = buffer, .instance_stride = stride}, .instances = 2};
  };
  const auto apart = [&](std::uint32_t stride, std::uint32_t normal_offset = 12) {
    return VertexLayout{
        .buffer = buffer, .normal_offset = normal_offset, .attributes = {buffer, 0, stride}};
  };
  using enum VertexFormat;
  struct Refused {
    const char* words;
    SolveOptions options;
  };
  const Refused refused[] = {
      {"multiples of 4", {.vertices = {buffer, 2}}},
      {"stride 20 does not hold 12 bytes from offset 12", {.vertices = {buffer, 0, 20}}},
      {"max_vertex_stride", {.vertices = {buffer, 0, 128}}},
      {"12 or more apart", {.given = {buffer, 0, 8}}},
      {"max_iterations 0 is outside 1 to", {.max_iterations = 0}},
      // Further slots.
      {"17 slots are more than 16", {.further_slots = std::vector<FrameSlot>(16)}},
      {"12 or more apart", {.further_slots = {{}, {.given = {buffer, 0, 8}}}}},
      {"does not hold 12 bytes", {.further_slots = {{.vertices = {buffer, 0, 20}}}}},
      {"vertices of an instance take",
       {.further_slots = {{.vertices = {.buffer = buffer, .instance_stride = 40}}},
        .instances = 2}},
      // Instances.
      {"instances 0 are outside 1 to 65535", {.instances = 0}},
      {"instances 65536 are outside 1 to 65535", {.instances = 65536}},
      {"vertices of an instance take", instances(bytes - 4)},
      {"multiples of 4 bytes", instances(bytes - 2)},
      // Formats and streams.
      {"not of a format for normals", {.vertices = {.buffer = buffer, .position_format = Snorm10}}},
      {"not of a format for positions", {.vertices = {.buffer = buffer, .normal_format = Half4}}},
      {"halves above 0", {.vertices = {.buffer = buffer, .box_half = {1, 0, 1}}}},
      {"a vertex of stride 12 does not hold 12 bytes from offset 12 on",
       {.vertices = {.buffer = buffer, .stride = 12, .position_format = Snorm16x4}}},
      {"a vertex of stride 4 does not hold 12 bytes from offset 0 on",
       {.vertices = {.buffer = buffer,
                     .stride = 4,
                     .normal_offset = 0,
                     .normal_format = Snorm10,
                     .attributes = {buffer, 0, 4}}}},
      {"a vertex of stride 12 does not hold 12 bytes from offset 4 on", {.vertices = apart(12, 4)}},
      {"max_vertex_stride", {.vertices = apart(128)}},
      {"multiples of 4 bytes", {.vertices = apart(26)}},
      {"make it textured", {.vertices = {.buffer = buffer, .tangent_offset = 24}}},
      {"tangents are Float4 or Snorm10",
       {.vertices = {.buffer = buffer, .tangent_format = Float3}}}};
  const auto expect_refused = [&](const DeviceSystem& tables, const Refused& row) {
    SCOPED_TRACE(row.words);
    expect_refusal(ErrorCode::InvalidArgument, row.words,
                   [&] { const vulkan::Solve solve(*context_, tables, row.options); });
  };
  for (const Refused& row : refused) expect_refused(topology.device, row);
  expect_refused(fair.device, {"record_solves()", {.vertices = {buffer}, .instances = 2}});
  expect_refused(fair.device, {"polish_steps 1001", {.polish_steps = 1001}});
}

TEST_F(Embedding, WritesOneUploadOfWhatItWasMadeFor) {
  System system(test::cube());
  const vulkan::DeviceSystem tables(*context_, system);
  std::vector<std::byte> staging(tables.upload_bytes());
  const auto refuse = [&](const System& from, std::size_t size, const std::string& words) {
    expect_refusal(ErrorCode::InvalidArgument, words,
                   [&] { tables.write_upload(from, std::span(staging).first(size)); });
  };
  refuse(System(test::icosphere(1)), staging.size(), "not of the System");
  refuse(System(test::cube()), staging.size(), "not of the System");
  refuse(system, staging.size() - 1, "bytes of staging memory");
  const System moved = std::move(system);
  tables.write_upload(moved, staging);
  refuse(moved, staging.size(), "was written before");
}

// Recording: that it does nothing but record, and what a host does with what was recorded: submits
// it again, keeps several frames in flight, records on several threads. Vertices are, bit by bit,
// those of a frame that is recorded, submitted and waited for by itself.

struct Recording {
  const char* name;
  PolygonMesh mesh;
  SystemOptions options;
};

class EmbedRecording : public Embedding {
 protected:
  static std::vector<Recording> recordings() {
    return {{"progressive", test::torus(12, 7, 2, 0.7), {}},
            {"creased", test::with_random_creases(test::random_open_mesh(2), 0.1, 3), {.level = 1}},
            {"fair", test::random_closed_mesh(4), {.method = InterpolationMethod::Fair}}};
  }
};

TEST_F(EmbedRecording, KernelsAreCompiledWhenTheyAreFirstWanted) {
  const auto compiled = [] { return PretendedDriver::count("vkCreateComputePipelines"); };
  EXPECT_EQ(compiled(), 0);  // by the Context
  const HostTopology topology = topology_of(test::icosphere(1));
  EXPECT_EQ(compiled(), 0);
  const HostFrame frame = frame_of(topology);
  const int first = compiled();
  EXPECT_GT(first, 8);
  // Nothing of conjugate gradients, edits, places, levels or the fair method.
  EXPECT_LT(first, 20);
  const HostFrame again = frame_of(topology);
  EXPECT_EQ(compiled(), first);
}

TEST_F(EmbedRecording, DoesNothingButRecord) {
  const PolygonMesh mesh = test::icosphere(3);  // more points than one work group takes at once
  const HostTopology topology = topology_of(mesh);
  HostFrame frame = frame_of(topology);
  const vulkan::Solve staged(*context_, topology.device,
                             {.vertices = {.buffer = frame.output.handle()}});
  frame.set_points(mesh);
  HostCommands commands(*own_);
  std::map<std::string, int> calls = recorded_calls(commands, [&](VkCommandBuffer buffer) {
    topology.device.record_upload(buffer, topology.staging.handle(), 0,
                                  {topology.indices.handle(), 0});
    staged.record_reset(buffer);
    staged.record_given(buffer, frame.points.handle(), 0);
    for (const bool warm : {false, true})
      for (const float stop : {-1.0f, 1e-6f}) {
        SolveParameters parameters = stopping(20, stop);
        parameters.warm_start = warm;
        staged.record_solve(buffer, parameters);
      }
    staged.record_evaluate(buffer);
    staged.record_status(buffer, frame.report.handle(), 0);
  });
  EXPECT_GT(calls["vkCmdDispatch"], 20);
  EXPECT_EQ(calls["vkCmdDispatchIndirect"], 2 * 21);
  EXPECT_EQ(calls["vkCmdBeginDebugUtilsLabelEXT"], calls["vkCmdEndDebugUtilsLabelEXT"]);
  // Enabled with validation only.
  EXPECT_GE(calls["vkCmdBeginDebugUtilsLabelEXT"], validation_wanted() ? 6 : 0);
  // Nothing that planish could call escapes the count.
  EXPECT_THAT(PretendedDriver::uncounted(),
              ::testing::Each(::testing::Key(::testing::StartsWith("vkEnumerateInstance"))));
  commands.submit();
  commands.wait();
}

TEST_F(EmbedRecording, NamesObjectsOnlyWhereTheHostEnabledIt) {
  if (!validation_wanted()) GTEST_SKIP() << "nothing is enabled where PLANISH_TEST_VALIDATION is 0";
  (void)topology_of(test::cube());
  EXPECT_GT(PretendedDriver::count("vkSetDebugUtilsObjectNameEXT"), 5);
  HostDevice host = own_->host_device();
  host.features.debug_utils = false;
  const int named = PretendedDriver::count("vkSetDebugUtilsObjectNameEXT");
  Context silent(host);
  Submitter submitter(silent, own_->queue(), own_->capabilities().compute_family);
  const HostTopology tables(silent, submitter, test::cube());
  const HostFrame frame(silent, tables);
  HostCommands commands(*own_);
  commands.record([&](VkCommandBuffer buffer) { frame.record(buffer, iterations(3)); });
  EXPECT_EQ(PretendedDriver::count("vkSetDebugUtilsObjectNameEXT"), named);
}

TEST_F(EmbedRecording, ResubmissionFollowsTheHostsPoints) {
  SolveParameters parameters = stopping(40, 1e-6);
  parameters.warm_start = true;
  for (const auto& [name, mesh, options] : recordings()) {
    SCOPED_TRACE(name);
    const HostTopology topology = topology_of(mesh, options);
    HostFrame frame = frame_of(topology), fresh = frame_of(topology);
    HostCommands commands(*own_);
    submitter_->run([&](VkCommandBuffer buffer) {
      frame.solve.record_reset(buffer);
      fresh.solve.record_reset(buffer);
    });
    commands.record([&](VkCommandBuffer buffer) { frame.record(buffer, parameters); });
    for (int i = 0; i < 5; ++i) {
      frame.set_points(posed(mesh, i));
      commands.submit();
      commands.wait();
      EXPECT_TRUE(same_bits(frame.vertices(), run(fresh, posed(mesh, i), parameters))) << i;
    }
  }
}

TEST_F(EmbedRecording, SecondaryCommandBuffersServe) {
  const PolygonMesh mesh = test::icosphere(1);
  const HostTopology topology = topology_of(mesh);
  HostFrame frame = frame_of(topology), alone = frame_of(topology);
  frame.set_points(mesh);
  HostCommands secondary(*own_, VK_COMMAND_BUFFER_LEVEL_SECONDARY), primary(*own_);
  secondary.record([&](VkCommandBuffer buffer) { frame.record(buffer, iterations(30)); });
  const HostDevice host = own_->host_device();
  const auto execute = reinterpret_cast<PFN_vkCmdExecuteCommands>(
      host.get_instance_proc(host.instance, "vkCmdExecuteCommands"));
  primary.record([&](VkCommandBuffer buffer) {
    const VkCommandBuffer inner = secondary.handle();
    execute(buffer, 1, &inner);
  });
  primary.submit();
  primary.wait();
  EXPECT_TRUE(same_bits(frame.vertices(), run(alone, mesh, iterations(30))));
}

TEST_F(EmbedRecording, TwoFramesInFlight) {
  SolveParameters parameters = stopping(40, 1e-6);
  for (const auto& [name, mesh, options] : recordings()) {
    SCOPED_TRACE(name);
    const HostTopology topology = topology_of(mesh, options);
    HostFrame frames[] = {frame_of(topology), frame_of(topology)},
              alone[] = {frame_of(topology), frame_of(topology)};
    HostCommands commands[] = {{*own_}, {*own_}};
    std::vector<std::vector<Vertex>> expected;
    for (int number = 0; number < 8; ++number) {
      parameters.warm_start = number >= 2;
      expected.push_back(run(alone[number % 2], posed(mesh, number), parameters));
    }
    for (int number = 0; number < 10; ++number) {
      HostFrame& frame = frames[number % 2];
      HostCommands& of_frame = commands[number % 2];
      if (number >= 2) {  // the last is still in flight
        of_frame.wait();
        EXPECT_TRUE(same_bits(frame.vertices(), expected[number - 2])) << number - 2;
      }
      if (number >= 8) continue;
      parameters.warm_start = number >= 2;
      frame.set_points(posed(mesh, number));
      of_frame.record([&](VkCommandBuffer buffer) { frame.record(buffer, parameters); });
      of_frame.submit();
    }
  }
}

TEST_F(EmbedRecording, InstancesShareATopology) {
  const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
  const HostTopology topology = topology_of(mesh);
  HostFrame instances[] = {frame_of(topology), frame_of(topology), frame_of(topology)},
            alone = frame_of(topology);
  for (int i = 0; i < 3; ++i) instances[i].set_points(posed(mesh, 5 * i));
  submitter_->run([&](VkCommandBuffer buffer) {
    for (const HostFrame& instance : instances) instance.record(buffer, iterations(40));
  });
  for (int i = 0; i < 3; ++i)
    EXPECT_TRUE(same_bits(instances[i].vertices(), run(alone, posed(mesh, 5 * i), iterations(40))));
}

TEST_F(EmbedRecording, TwoThreadsMakeAndRecordSolves) {
  const PolygonMesh mesh = test::icosphere(2);
  const HostTopology topology = topology_of(mesh);
  std::unique_ptr<HostFrame> frames[2];
  std::unique_ptr<HostCommands> commands[2];
  const auto work = [&](int i) {
    for (int round = 0; round < 3; ++round) {
      frames[i] = std::make_unique<HostFrame>(*context_, topology);
      commands[i] = std::make_unique<HostCommands>(*own_);
      frames[i]->set_points(posed(mesh, i));
      commands[i]->record(
          [&](VkCommandBuffer buffer) { frames[i]->record(buffer, stopping(40, 1e-6)); });
    }
  };
  std::thread other(work, 1);
  work(0);
  other.join();
  // A VkQueue is the host's to guard.
  for (const auto& recorded : commands) recorded->submit();
  HostFrame alone = frame_of(topology);
  for (int i = 0; i < 2; ++i) {
    commands[i]->wait();
    EXPECT_TRUE(same_bits(frames[i]->vertices(), run(alone, posed(mesh, i), stopping(40, 1e-6))));
  }
}

TEST_F(EmbedRecording, TimestampsGoToTheHostsPool) {
  if (own_->capabilities().timestamp_bits == 0) GTEST_SKIP() << "the device has no timestamps";
  const PolygonMesh mesh = test::icosphere(2);
  const HostTopology topology = topology_of(mesh);
  HostFrame frame = frame_of(topology);
  frame.set_points(mesh);
  const HostDevice host = own_->host_device();
  const auto load = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::decay_t<decltype(function)>>(
        host.get_instance_proc(host.instance, name));
  };
  PFN_vkCreateQueryPool create;
  PFN_vkDestroyQueryPool destroy;
  PFN_vkCmdResetQueryPool reset;
  PFN_vkGetQueryPoolResults results;
  load(create, "vkCreateQueryPool");
  load(destroy, "vkDestroyQueryPool");
  load(reset, "vkCmdResetQueryPool");
  load(results, "vkGetQueryPoolResults");
  VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = 6;
  VkQueryPool pool = VK_NULL_HANDLE;
  ASSERT_EQ(create(host.device, &info, nullptr, &pool), VK_SUCCESS);
  HostCommands commands(*own_);
  commands.record([&](VkCommandBuffer buffer) {
    reset(buffer, pool, 0, 6);
    SolveParameters parameters = iterations(40);
    parameters.timestamps = {pool, 1};
    frame.solve.record_solve(buffer, parameters);
    frame.solve.record_evaluate(buffer, {.timestamps = {pool, 3}});
  });
  commands.submit();
  commands.wait();
  std::uint64_t times[4] = {};
  EXPECT_EQ(results(host.device, pool, 1, 4, sizeof times, times, sizeof times[0],
                    VK_QUERY_RESULT_64_BIT),
            VK_SUCCESS);
  EXPECT_LT(times[0], times[1]);
  EXPECT_LE(times[1], times[2]);
  EXPECT_LT(times[2], times[3]);
  destroy(host.device, pool, nullptr);
  // One at the top of the pipe is held back by no barrier, and counts the end of the work before.
  const auto stages = PretendedDriver::notes().timestamp_stages;
  EXPECT_EQ(stages.count(VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT), 1u);
  EXPECT_EQ(stages.count(VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT), 0u);
}

}  // namespace
}  // namespace planish::testing
