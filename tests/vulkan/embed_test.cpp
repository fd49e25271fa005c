#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <iostream>
#include <limits>
#include <thread>

#include "planish/mesh/face_geometry.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/surface_blocks.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/embed.h"
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
  PolygonMesh unused = test::torus(9, 6, 2, 0.7);
  unused.positions.insert(unused.positions.begin() + 20, glm::dvec3(100, 0, 0));
  for (std::int32_t& v : unused.face_vertices) v += v >= 20;
  // Given points are read from the first used vertex on.
  PolygonMesh late = test::torus(9, 6, 2, 0.7);
  late.positions.insert(late.positions.begin(), 7, glm::dvec3(0, 100, 0));
  for (std::int32_t& v : late.face_vertices) v += 7;
  PolygonMesh holed = test::torus(9, 6, 2, 0.7);
  holed.hole_faces = {3, 17};
  return {{"icosphere", test::icosphere(2)},
          {"torus", test::torus(12, 7, 2, 0.7)},
          {"random", test::random_closed_mesh(3)},
          {"open", test::random_open_mesh(4)},
          {"creases", test::with_random_creases(test::random_open_mesh(5), 0.15, 6)},
          {"unused vertex", unused},
          {"holes", holed},
          {"unused vertices first", late}};
}

TEST_F(Embedding, SurfaceEqualsTheCpus) {
  for (const test::NamedMesh& mesh : mixed_meshes())
    for (const int level : {0, 1, 2}) {
      SystemOptions options;
      options.level = level;
      HostTopology topology(*context_, mesh.mesh, options);
      topology.upload(*submitter_);
      HostFrame frame(*context_, topology);
      const PolygonMesh pose = posed(mesh.mesh, 1);
      const Difference off =
          difference(run(frame, pose, iterations(40)), surface_by_cpu(pose, mesh.mesh, options));
      EXPECT_LT(off.distance, kEmbedDistance) << mesh.name << " " << level;
      EXPECT_GT(off.cosine, kCosine) << mesh.name << " " << level;
      EXPECT_EQ(frame.status().iterations, 40u);
      EXPECT_EQ(frame.status().state, SolveState::Stepped);
      EXPECT_LT(frame.status().residual, 2e-6) << mesh.name << " " << level;
    }
}

TEST_F(Embedding, IndicesAreTheCpuSurfaces) {
  for (const test::NamedMesh& mesh : mixed_meshes())
    for (const int level : {0, 2}) {
      SystemOptions options;
      options.level = level;
      HostTopology topology(*context_, mesh.mesh, options);
      topology.upload(*submitter_);
      EvaluateOptions evaluation;
      evaluation.level = level;
      // A host keeps the vertices that only holes name.
      const PolygonMesh whole = without_holes(mesh.mesh);
      const auto backend = make_cpu_backend();
      const SurfaceMesh surface = evaluate(whole, fit(whole, *backend), *backend, evaluation);
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
      std::vector<std::uint32_t> indices(topology.device.index_count());
      ASSERT_EQ(indices.size(), expected.size()) << mesh.name;
      std::memcpy(indices.data(), topology.indices.mapped().data(), 4 * indices.size());
      EXPECT_EQ(indices, expected) << mesh.name << " " << level;
      if (level == 0) continue;
      EXPECT_TRUE(std::equal(topology.system.quads().begin(), topology.system.quads().end(),
                             quads.begin(), quads.end()))
          << mesh.name;
    }
}

TEST_F(Embedding, WritesTheHostsLayoutAndNothingBeside) {
  const PolygonMesh mesh = test::icosphere(1);
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  HostFrame tight(*context_, topology);
  const std::vector<Vertex> expected = run(tight, mesh, iterations(20));
  // Normals before positions, at an offset that no device takes as a binding's.
  for (const Layout& layout : {Layout{52, 40, 16, 0}, Layout{4, 64, 0, 52}, Layout{0, 24, 12, 0}}) {
    HostFrame frame(*context_, topology, layout);
    std::memset(frame.output.mapped().data(), 0x5a, frame.output.mapped().size());
    frame.output.flush();
    const std::vector<Vertex> found = run(frame, mesh, iterations(20));
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      ASSERT_EQ(found[i].position, expected[i].position) << i;
      ASSERT_EQ(found[i].normal, expected[i].normal) << i;
      std::byte* vertex = &frame.output.mapped()[layout.offset + i * layout.stride];
      std::memset(vertex + layout.position_offset, 0x5a, sizeof(glm::vec3));
      std::memset(vertex + layout.normal_offset, 0x5a, sizeof(glm::vec3));
    }
    EXPECT_THAT(frame.output.mapped(), ::testing::Each(std::byte{0x5a}));
  }
}

TEST_F(Embedding, TakesPointsOfAnyStrideAndFromStaging) {
  const PolygonMesh mesh = mixed_meshes()[5].mesh;  // with an unused vertex
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  HostFrame tight(*context_, topology);
  const std::vector<Vertex> expected = run(tight, mesh, iterations(20));

  const std::size_t count = mesh.positions.size();
  Buffer strided(*context_, 20 + 32 * count, MemoryUse::Upload);
  Buffer staging(*context_, 8 + sizeof(glm::vec3) * count, MemoryUse::Upload);
  for (std::size_t i = 0; i < count; ++i) {
    const glm::vec3 point(mesh.positions[i]);
    std::memcpy(&strided.mapped()[20 + 32 * i], &point, sizeof point);
    std::memcpy(&staging.mapped()[8 + sizeof point * i], &point, sizeof point);
  }
  strided.flush();
  staging.flush();
  SolveOptions options;
  options.vertices.buffer = tight.output.handle();
  const vulkan::Solve staged(*context_, topology.device, options);
  options.given = {strided.handle(), 20, 32};
  const vulkan::Solve direct(*context_, topology.device, options);
  for (const vulkan::Solve* solve : {&staged, &direct}) {
    std::memset(tight.output.mapped().data(), 0, tight.output.mapped().size());
    submitter_->run([&](VkCommandBuffer commands) {
      if (solve == &staged) solve->record_given(commands, staging.handle(), 8);
      solve->record_solve(commands, iterations(20));
      solve->record_evaluate(commands);
    });
    const std::vector<Vertex> found = tight.vertices();
    for (std::size_t i = 0; i < found.size(); ++i) {
      ASSERT_EQ(found[i].position, expected[i].position) << i;
      ASSERT_EQ(found[i].normal, expected[i].normal) << i;
    }
  }
}

TEST_F(Embedding, StopsOnTheDeviceAtTheStepThatTheSystemCounted) {
  const PolygonMesh mesh = test::random_closed_mesh(3);
  SystemOptions options;
  options.tolerance = 1e-4;
  HostTopology topology(*context_, mesh, options);
  topology.upload(*submitter_);
  const std::uint32_t needed = topology.system.rest_iterations();
  ASSERT_GT(needed, 5u);  // so that indirect dispatches are both done and left out
  HostFrame frame(*context_, topology);
  SolveParameters parameters = iterations(60);
  parameters.stop_error = static_cast<float>(topology.system.tolerance());
  const std::vector<Vertex> stopped = run(frame, mesh, parameters);
  EXPECT_EQ(frame.status().iterations, needed);
  EXPECT_EQ(frame.status().state, SolveState::Converged);
  EXPECT_LE(frame.status().residual, parameters.stop_error);
  const std::vector<Vertex> counted = run(frame, mesh, iterations(needed));
  EXPECT_EQ(frame.status().state, SolveState::Stepped);
  EXPECT_EQ(frame.status().iterations, needed);
  for (std::size_t i = 0; i < counted.size(); ++i)
    ASSERT_EQ(stopped[i].position, counted[i].position) << i;
  // One step less does not suffice.
  static_cast<void>(run(frame, mesh, iterations(needed - 1)));
  EXPECT_GT(frame.status().residual, parameters.stop_error);
}

TEST_F(Embedding, StatusTellsTheErrorThatTheStepsLeave) {
  const PolygonMesh mesh = test::icosphere(2);
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  HostFrame frame(*context_, topology);
  static_cast<void>(run(frame, mesh, iterations(0)));
  EXPECT_NEAR(frame.status().residual, topology.system.rest_error(), 1e-6);
  for (const std::uint32_t count : {0u, 1u, 2u, 3u, 6u}) {
    const std::vector<Vertex> found = run(frame, mesh, iterations(count));
    double largest = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
      largest =
          std::max<double>(largest, glm::distance(glm::vec3(mesh.positions[v]), found[v].position));
    EXPECT_NEAR(frame.status().residual, largest, 1e-6) << count;
    SolveParameters before = iterations(count);
    before.measures_last = false;
    const float after = frame.status().residual;
    static_cast<void>(run(frame, mesh, before));
    EXPECT_EQ(frame.status().iterations, count);
    // Without any step there is nothing before the last.
    EXPECT_EQ(frame.status().residual == after, count == 0) << count;
    EXPECT_GE(frame.status().residual, after) << count;
  }
}

TEST_F(Embedding, WarmStartsNeedFewerIterations) {
  const PolygonMesh mesh = test::torus(14, 9, 2, 0.7);
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  HostFrame warm(*context_, topology), cold(*context_, topology);
  SolveParameters parameters = iterations(64);
  parameters.stop_error = 3e-6f;
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
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  HostFrame frame(*context_, topology);
  const std::vector<Vertex> expected = run(frame, mesh, iterations(20));
  PolygonMesh broken = mesh;
  broken.positions[7].y = std::numeric_limits<double>::quiet_NaN();
  SolveParameters parameters = iterations(20);
  parameters.stop_error = 1e-6f;
  static_cast<void>(run(frame, broken, parameters));
  EXPECT_EQ(frame.status().state, SolveState::NotFinite);
  EXPECT_EQ(frame.status().residual, std::numeric_limits<float>::infinity());
  parameters = iterations(40);
  parameters.warm_start = true;
  EXPECT_LT(difference(run(frame, mesh, parameters), expected).distance, kEmbedDistance);
}

TEST_F(Embedding, RefusesLayoutsThatCannotBe) {
  const PolygonMesh mesh = test::cube();
  HostTopology topology(*context_, mesh);
  HostFrame frame(*context_, topology);
  const auto refuse = [&](const SolveOptions& options, const char* words) {
    try {
      const vulkan::Solve solve(*context_, topology.device, options);
      ADD_FAILURE() << "nothing thrown: " << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_THAT(error.what(), ::testing::HasSubstr(words));
    }
  };
  const VkBuffer buffer = frame.output.handle();
  refuse({.vertices = {buffer, 2}}, "multiples of 4");
  refuse({.vertices = {buffer, 0, 20}}, "stride 20 does not hold 12 bytes from offset 12");
  refuse({.vertices = {buffer, 0, 128}}, "max_vertex_stride");
  refuse({.given = {buffer, 0, 8}}, "12 or more apart");
  refuse({.max_iterations = 0}, "max_iterations 0 is outside 1 to");
}

TEST_F(Embedding, WritesOneUploadOfWhatItWasMadeFor) {
  System system(test::cube());
  const vulkan::DeviceSystem tables(*context_, system);
  std::vector<std::byte> staging(tables.upload_bytes());
  const auto refuse = [&](const System& from, std::size_t size, const std::string& words) {
    try {
      tables.write_upload(from, std::span(staging).first(size));
      ADD_FAILURE() << "nothing thrown: " << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_THAT(error.what(), ::testing::HasSubstr(words));
    }
  };
  refuse(System(test::icosphere(1)), staging.size(), "not of the System");
  refuse(System(test::cube()), staging.size(), "not of the System");
  refuse(system, staging.size() - 1, "bytes of staging memory");
  const System moved = std::move(system);
  tables.write_upload(moved, staging);
  refuse(moved, staging.size(), "was written before");
}

// Recording: that it does nothing but record, and what a host does with what was recorded: submits
// it again, keeps several frames in flight, records on several threads.
using ::testing::StartsWith;

// Single precision of coordinates of a few units.
constexpr double kDistance = 4e-6;

class EmbedRecording : public Embedding {
 protected:
  /// Tables on the device, and their upload done.
  std::unique_ptr<HostTopology> make_topology(const PolygonMesh& mesh) {
    auto topology = std::make_unique<HostTopology>(*context_, mesh);
    topology->upload(*submitter_);
    return topology;
  }

  void expect_surface(HostFrame& frame, const PolygonMesh& pose, const PolygonMesh& rest,
                      const std::string& what) {
    EXPECT_LT(difference(frame.vertices(), surface_by_cpu(pose, rest, {})).distance, kDistance)
        << what;
  }
};

// What was called between two counts.
std::map<std::string, int> calls_since(const std::map<std::string, int>& before) {
  std::map<std::string, int> calls;
  for (const auto& [name, count] : PretendedDriver::counts()) {
    const auto found = before.find(name);
    const int since = count - (found == before.end() ? 0 : found->second);
    if (since > 0) calls[name] = since;
  }
  return calls;
}

TEST_F(EmbedRecording, KernelsAreCompiledWhenTheyAreFirstWanted) {
  const auto compiled = [] { return PretendedDriver::count("vkCreateComputePipelines"); };
  EXPECT_EQ(compiled(), 0);  // by the Context
  HostTopology topology(*context_, test::icosphere(1));
  EXPECT_EQ(compiled(), 0);
  const HostFrame frame(*context_, topology);
  const int first = compiled();
  EXPECT_GT(first, 8);
  // Nothing of conjugate gradients, edits, places, levels or the fair method.
  EXPECT_LT(first, 20);
  const HostFrame again(*context_, topology);
  EXPECT_EQ(compiled(), first);
}

TEST_F(EmbedRecording, DoesNothingButRecord) {
  const PolygonMesh mesh = test::icosphere(3);  // more points than one work group takes at once
  const auto topology = make_topology(mesh);
  HostFrame frame(*context_, *topology);
  SolveOptions options;
  options.vertices.buffer = frame.output.handle();
  const vulkan::Solve staged(*context_, topology->device, options);
  frame.set_points(mesh);
  std::map<std::string, int> calls;
  HostCommands commands(*own_);
  commands.record([&](VkCommandBuffer buffer) {
    const std::map<std::string, int> before = PretendedDriver::counts();
    topology->device.record_upload(buffer, topology->staging.handle(), 0,
                                   {topology->indices.handle(), 0});
    staged.record_reset(buffer);
    staged.record_given(buffer, frame.points.handle(), 0);
    for (const bool warm : {false, true})
      for (const float stop : {-1.0f, 1e-6f}) {
        SolveParameters parameters = iterations(20);
        parameters.warm_start = warm;
        parameters.stop_error = stop;
        staged.record_solve(buffer, parameters);
      }
    staged.record_evaluate(buffer);
    staged.record_status(buffer, frame.report.handle(), 0);
    calls = calls_since(before);
  });
  for (const auto& [name, count] : calls) {
    std::cout << "  " << name << " " << count << "\n";
    EXPECT_THAT(name, StartsWith("vkCmd"));
  }
  EXPECT_GT(calls["vkCmdDispatch"], 20);
  EXPECT_EQ(calls["vkCmdDispatchIndirect"], 2 * 21);
  EXPECT_EQ(calls["vkCmdBeginDebugUtilsLabelEXT"], calls["vkCmdEndDebugUtilsLabelEXT"]);
  // Enabled with validation only.
  EXPECT_GE(calls["vkCmdBeginDebugUtilsLabelEXT"], validation_wanted() ? 6 : 0);
  // Nothing that planish could call escapes the count.
  EXPECT_THAT(PretendedDriver::uncounted(),
              ::testing::Each(::testing::Key(StartsWith("vkEnumerateInstance"))));
  // An embedded context asks for nothing of the host's queue either.
  commands.submit();
  commands.wait();
}

TEST_F(EmbedRecording, NamesObjectsOnlyWhereTheHostEnabledIt) {
  if (!validation_wanted()) GTEST_SKIP() << "nothing is enabled where PLANISH_TEST_VALIDATION is 0";
  const auto topology = make_topology(test::cube());
  EXPECT_GT(PretendedDriver::count("vkSetDebugUtilsObjectNameEXT"), 5);
  HostDevice host = own_->host_device();
  host.features.debug_utils = false;
  const int named = PretendedDriver::count("vkSetDebugUtilsObjectNameEXT");
  Context silent(host);
  const HostTopology tables(silent, test::cube());
  const HostFrame frame(silent, tables);
  HostCommands commands(*own_);
  commands.record([&](VkCommandBuffer buffer) { frame.record(buffer, iterations(3)); });
  EXPECT_EQ(PretendedDriver::count("vkSetDebugUtilsObjectNameEXT"), named);
}

TEST_F(EmbedRecording, ResubmissionFollowsTheHostsPoints) {
  const PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  const auto topology = make_topology(mesh);
  HostFrame frame(*context_, *topology);
  HostCommands commands(*own_);
  SolveParameters parameters = iterations(40);
  parameters.warm_start = true;
  parameters.stop_error = 1e-6f;
  submitter_->run([&](VkCommandBuffer buffer) { frame.solve.record_reset(buffer); });
  commands.record([&](VkCommandBuffer buffer) { frame.record(buffer, parameters); });
  for (int i = 0; i < 5; ++i) {
    const PolygonMesh pose = posed(mesh, i);
    frame.set_points(pose);
    commands.submit();
    commands.wait();
    expect_surface(frame, pose, mesh, "frame " + std::to_string(i));
  }
}

TEST_F(EmbedRecording, SecondaryCommandBuffersServe) {
  const PolygonMesh mesh = test::icosphere(1);
  const auto topology = make_topology(mesh);
  HostFrame frame(*context_, *topology);
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
  expect_surface(frame, mesh, mesh, "secondary");
}

TEST_F(EmbedRecording, TwoFramesInFlight) {
  const PolygonMesh mesh = test::random_closed_mesh(4);
  const auto topology = make_topology(mesh);
  struct InFlight {
    InFlight(const OwnDevice& device, Context& context, const HostTopology& topology_of)
        : frame(context, topology_of), commands(device) {}
    HostFrame frame;
    HostCommands commands;
    int number = -1;
  };
  std::unique_ptr<InFlight> ring[2];
  for (auto& slot : ring) slot = std::make_unique<InFlight>(*own_, *context_, *topology);
  SolveParameters parameters = iterations(40);
  parameters.stop_error = 1e-6f;
  const auto finish = [&](InFlight& slot) {
    if (slot.number < 0) return;
    slot.commands.wait();
    expect_surface(slot.frame, posed(mesh, slot.number), mesh, std::to_string(slot.number));
  };
  for (int number = 0; number < 8; ++number) {
    InFlight& slot = *ring[number % 2];
    finish(slot);  // the frame before the last; the last is still in flight
    parameters.warm_start = slot.number >= 0;
    slot.number = number;
    slot.frame.set_points(posed(mesh, number));
    slot.commands.record([&](VkCommandBuffer buffer) { slot.frame.record(buffer, parameters); });
    slot.commands.submit();
  }
  for (auto& slot : ring) finish(*slot);
}

TEST_F(EmbedRecording, InstancesShareATopology) {
  const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
  const auto topology = make_topology(mesh);
  std::vector<std::unique_ptr<HostFrame>> instances;
  for (int i = 0; i < 3; ++i) {
    instances.push_back(std::make_unique<HostFrame>(*context_, *topology));
    instances[i]->set_points(posed(mesh, 5 * i));
  }
  HostCommands commands(*own_);
  commands.record([&](VkCommandBuffer buffer) {
    for (const auto& instance : instances) instance->record(buffer, iterations(40));
  });
  commands.submit();
  commands.wait();
  for (int i = 0; i < 3; ++i)
    expect_surface(*instances[i], posed(mesh, 5 * i), mesh, "instance " + std::to_string(i));
}

TEST_F(EmbedRecording, TwoThreadsMakeAndRecordSolves) {
  const PolygonMesh mesh = test::icosphere(2);
  const auto topology = make_topology(mesh);
  std::unique_ptr<HostFrame> frames[2];
  std::unique_ptr<HostCommands> commands[2];
  const auto work = [&](int i) {
    for (int round = 0; round < 3; ++round) {
      frames[i] = std::make_unique<HostFrame>(*context_, *topology);
      commands[i] = std::make_unique<HostCommands>(*own_);
      frames[i]->set_points(posed(mesh, i));
      commands[i]->record([&](VkCommandBuffer buffer) {
        SolveParameters parameters = iterations(40);
        parameters.stop_error = 1e-6f;
        frames[i]->record(buffer, parameters);
      });
    }
  };
  std::thread other(work, 1);
  work(0);
  other.join();
  // A VkQueue is the host's to guard.
  for (const auto& recorded : commands) recorded->submit();
  for (int i = 0; i < 2; ++i) {
    commands[i]->wait();
    expect_surface(*frames[i], posed(mesh, i), mesh, "thread " + std::to_string(i));
  }
}

TEST_F(EmbedRecording, TimestampsGoToTheHostsPool) {
  if (own_->capabilities().timestamp_bits == 0) GTEST_SKIP() << "the device has no timestamps";
  const PolygonMesh mesh = test::icosphere(2);
  const auto topology = make_topology(mesh);
  HostFrame frame(*context_, *topology);
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
