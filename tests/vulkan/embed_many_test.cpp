// Several meshes in one command buffer: the same bits as one by one, with the barriers of one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;

/// One mesh with its tables and two frames: one recorded by itself, one beside others.
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
