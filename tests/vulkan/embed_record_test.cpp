// Recording: that it does nothing but record, and what a host does with what was recorded: submits
// it again, keeps several frames in flight, records on several threads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <iostream>
#include <thread>

#include "planish/vulkan/device/driver.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;
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

/// What was called between two counts.
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
