#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include "planish/queries/limit_surface.h"
#include "planish/vulkan/device/own_device.h"
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
    vulkan::OwnDeviceOptions options;
    options.wanted = test::wanted_device();
    options.instance.get_proc = PretendedDriver::get_proc();
    options.instance.validation = validation_wanted();
    options.instance.message = [this](std::string_view message) {
      const std::lock_guard lock(mutex_);
      messages_.emplace_back(message);
    };
    return options;
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

  /// Gives the points, runs solve, evaluation and status, and fetches the vertices.
  std::vector<Vertex> run(HostFrame& frame, const PolygonMesh& pose,
                          const vulkan::SolveParameters& parameters) {
    frame.set_points(pose);
    submitter_->run([&](VkCommandBuffer commands) { frame.record(commands, parameters); });
    return frame.vertices();
  }

  std::unique_ptr<vulkan::OwnDevice> own_;
  std::unique_ptr<vulkan::Context> context_;
  std::unique_ptr<vulkan::Submitter> submitter_;
};

[[nodiscard]] inline vulkan::SolveParameters iterations(std::uint32_t count) {
  vulkan::SolveParameters parameters;
  parameters.iterations = count;
  parameters.measures_last = true;
  return parameters;
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
          staging(context, tables.upload_bytes(), vulkan::MemoryUse::Upload),
          points(context, tables.given_count() * sizeof(glm::vec3), vulkan::MemoryUse::Upload),
          solve(context, tables, {.given = {points.handle()}}),
          list(context, std::max(1u, places.list.count) * sizeof(PlaceRecord),
               vulkan::MemoryUse::Upload),
          results(context, std::max(1u, places.list.count) * sizeof(PlaceResult),
                  vulkan::MemoryUse::Download) {
      tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
      staging.flush();
      submitter.run(
          [&](VkCommandBuffer commands) { tables.record_upload(commands, staging.handle(), 0); });
      const std::vector<glm::vec3> rounded(mesh.positions.begin(), mesh.positions.end());
      std::memcpy(points.mapped().data(), rounded.data(), rounded.size() * sizeof rounded[0]);
      points.flush();
    }
    vulkan::System system;
    vulkan::DeviceSystem tables;
    vulkan::Buffer staging, points;
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
    std::memcpy(c.list.mapped().data(), places.data(), places.size() * sizeof places[0]);
    c.list.flush();
    const vulkan::Places asked(
        *context_, c.tables, c.solve,
        {.list = {c.list.handle(), 0, 12, count}, .results = {.buffer = c.results.handle()}});
    submitter_->run([&](VkCommandBuffer commands) {
      c.solve.record_solve(commands, {.iterations = step_count});
      c.solve.record_surface(commands);
      asked.record_evaluate(commands);
    });
    c.results.invalidate();
    std::vector<PlaceResult> results(places.size());
    std::memcpy(results.data(), c.results.mapped().data(), results.size() * sizeof results[0]);
    return results;
  }

  void open_reading(vulkan::ReadPath path, const vulkan::ContextOptions& given = {}) {
    vulkan::ContextOptions options = given;
    options.variant =
        path == vulkan::ReadPath::Texel ? vulkan::kSoftwareVariant : vulkan::kHardwareVariant;
    open(options);
  }
};

}  // namespace planish::testing
