#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "planish/queries/limit_surface.h"
#include "support/calls.h"
#include "vulkan/device_cases.h"
#include "vulkan/embedding.h"
#include "vulkan/fixture.h"
#include "vulkan/pretended_driver.h"

namespace planish::testing {

/// A host with its device, on a driver that counts and pretends. Any message of the validation
/// layer fails the test, and so does what is left alive.
class Embedding : public VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    PretendedDriver::reset();
    open();
  }

  void TearDown() override {
    close();
    EXPECT_TRUE(PretendedDriver::alive().empty());
    for (const std::string& rule : PretendedDriver::broken_rules()) ADD_FAILURE() << rule;
    VulkanTest::TearDown();
  }

  vulkan::OwnDeviceOptions device_options() {
    return VulkanTest::device_options(PretendedDriver::get_proc());
  }

  void open(const vulkan::ContextOptions& options = {}) {
    close();
    own_ = std::make_unique<vulkan::OwnDevice>(device_options());
    context_ = std::make_unique<vulkan::Context>(*own_, options);
    submitter_ = std::make_unique<vulkan::Submitter>(*context_, own_->queue(),
                                                     own_->capabilities().compute_family);
  }

  /// With a context of each variant of the kernels.
  template <class Work>
  void with_both_variants(const Work& work) {
    for (const vulkan::PipelineVariant& variant :
         {vulkan::kSoftwareVariant, vulkan::kHardwareVariant}) {
      open({.variant = variant});
      work();
    }
  }

  void close() {
    submitter_.reset();
    context_.reset();
    own_.reset();
  }

  HostTopology topology_of(const PolygonMesh& mesh, const vulkan::SystemOptions& options = {},
                           const vulkan::DeviceSystemOptions& tables = {}) {
    return {*context_, *submitter_, mesh, options, tables};
  }

  HostFrame frame_of(const HostTopology& topology, const Layout& layout = {},
                     std::uint32_t instances = 1) {
    return {*context_, topology, layout, instances};
  }

  /// Gives the points, runs solve, evaluation and status, and fetches the vertices.
  std::vector<Vertex> run(HostFrame& frame, const PolygonMesh& pose,
                          const vulkan::SolveParameters& parameters) {
    frame.set_points(pose);
    submitter_->run([&](VkCommandBuffer commands) { frame.record(commands, parameters); });
    return frame.vertices();
  }

  /// What recording calls of the driver, which must be vkCmd functions alone.
  std::map<std::string, int> recorded_calls(HostCommands& commands,
                                            const std::function<void(VkCommandBuffer)>& record) {
    std::map<std::string, int> calls;
    commands.record([&](VkCommandBuffer buffer) {
      const std::map<std::string, int> before = PretendedDriver::counts();
      record(buffer);
      calls = PretendedDriver::counts();
      for (const auto& [name, count] : before) calls[name] -= count;
    });
    std::erase_if(calls, [](const auto& call) { return call.second == 0; });
    for (const auto& [name, count] : calls) EXPECT_TRUE(name.starts_with("vkCmd")) << name;
    return calls;
  }

  /// What is alive, but for one kind that a Context keeps until its own end.
  static std::map<std::string, int> alive_without(const std::string& kept) {
    std::map<std::string, int> all = PretendedDriver::alive();
    all.erase(kept);
    return all;
  }

  /// Expects Error{code} with these words of `action`, which leaves nothing behind.
  template <class Action>
  void expect_refusal(ErrorCode code, const std::string& words, const Action& action,
                      const std::string& kept = {}) {
    const std::map<std::string, int> before = alive_without(kept);
    const std::string message = test::message_of(code, action);
    EXPECT_NE(message.find(words), std::string::npos) << message << "\n  without: " << words;
    EXPECT_EQ(alive_without(kept), before) << message;
  }

  std::unique_ptr<vulkan::OwnDevice> own_;
  std::unique_ptr<vulkan::Context> context_;
  std::unique_ptr<vulkan::Submitter> submitter_;
};

/// Steps until the error is small enough.
[[nodiscard]] inline vulkan::SolveParameters stopping(std::uint32_t count, double stop_error) {
  return {.iterations = count, .stop_error = static_cast<float>(stop_error), .measures_last = true};
}

[[nodiscard]] inline vulkan::SolveParameters iterations(std::uint32_t count) {
  return {.iterations = count, .measures_last = true};
}

struct PlaceRecord {
  std::uint32_t face = 0;
  float u = 0, v = 0;
};

struct PlaceResult {
  glm::vec3 position, normal, du, dv, duu, duv, dvv;
  vulkan::PlaceState state;
};
static_assert(sizeof(PlaceResult) == 88);

[[nodiscard]] inline PolygonMesh in_floats(PolygonMesh mesh) {
  mesh.positions = through_floats(mesh.positions);
  return mesh;
}

/// The limit surface of the mesh itself as a cage, hole faces included.
struct PlaceOracle {
  PlaceOracle(const PolygonMesh& cage, Weights weights)
      : mesh(cage),
        limit(std::make_shared<const DooSabinSurface>(mesh, EvaluateOptions{.weights = weights})) {}
  PolygonMesh mesh;
  LimitSurface limit;
};

/// Anywhere, near vertices and centres, and on borders.
[[nodiscard]] inline std::vector<PlaceRecord> places_on(const MeshTopology& topology,
                                                        std::uint32_t seed, int each) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> within(0, 1);
  std::uniform_int_distribution<int> kind(0, 5), power(1, 20);
  std::vector<PlaceRecord> places;
  for (std::int32_t c = 0; c < topology.corner_count(); ++c)
    for (int i = 0; i < each; ++i) {
      double u = within(random), v = within(random);
      const double near = std::ldexp(1.0, -power(random));
      switch (kind(random)) {
        case 0:
          u *= near, v *= near;
          break;
        case 1:
          u = 1 - near * u, v = 1 - near * v;
          break;
        case 2:
          u = kind(random) / 5.0, v = kind(random) < 3 ? 0 : 1;
          break;
        default:
          break;
      }
      const SurfaceParameter at = surface_parameter(topology, c, u, v);
      places.push_back({static_cast<std::uint32_t>(at.face), static_cast<float>(at.u),
                        static_cast<float>(at.v)});
    }
  return places;
}

class PlacesOnDevice : public Embedding {
 protected:
  struct Case {
    Case(vulkan::Context& context, vulkan::Submitter& submitter, const PolygonMesh& mesh,
         const vulkan::SystemOptions& options = {}, const vulkan::PlacesOptions& places = {})
        : system(mesh, options),
          tables(context, system, {.answers_places = true}),
          points(context, tables.given_count() * sizeof(glm::vec3), vulkan::MemoryUse::Upload),
          solve(context, tables, {.given = {points.handle()}}),
          list(context, std::max(1u, places.list.count) * sizeof(PlaceRecord),
               vulkan::MemoryUse::Upload),
          results(context, std::max(1u, places.list.count) * sizeof(PlaceResult),
                  vulkan::MemoryUse::Download) {
      upload_tables(context, submitter, system, tables);
      put(points, points_of(mesh));
    }
    vulkan::System system;
    vulkan::DeviceSystem tables;
    vulkan::Buffer points;
    vulkan::Solve solve;
    vulkan::Buffer list, results;
  };

  /// Of the mesh itself as a cage.
  std::vector<PlaceResult> results_of(const PolygonMesh& mesh,
                                      const std::vector<PlaceRecord>& places,
                                      const vulkan::SystemOptions& options = {},
                                      std::uint32_t step_count = 0) {
    const auto count = static_cast<std::uint32_t>(places.size());
    Case c(*context_, *submitter_, mesh, options, {.list = {.count = count}});
    put(c.list, places);
    const vulkan::Places asked(
        *context_, c.tables, c.solve,
        {.list = {c.list.handle(), 0, 12, count}, .results = {.buffer = c.results.handle()}});
    submitter_->run([&](VkCommandBuffer commands) {
      c.solve.record_solve(commands, {.iterations = step_count});
      c.solve.record_surface(commands);
      asked.record_evaluate(commands);
    });
    return fetched<PlaceResult>(c.results, places.size());
  }
};

}  // namespace planish::testing
