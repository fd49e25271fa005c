// Fair nets around hubs and large faces, whose walks work groups share, against those of the CPU.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "planish/fair/fair_net.h"
#include "planish/surface/evaluate.h"
#include "vulkan/fair_machine.h"

namespace planish::testing {
namespace {

using glm::dvec3;

// Of unit diagonal, as of other nets: between control points, which the polish moves apart most,
// and between limit points and given points.
constexpr double kPoints = 1e-3;
constexpr double kLimits = 9e-8;

class FairHubs : public FairReads {
 protected:
  void equal_the_cpus(std::int32_t times) {
    for (const test::NamedMesh& mesh : large_rings(times)) {
      SCOPED_TRACE(mesh.name);
      const test::FairCase c(mesh.mesh);
      const DeviceNet net(*machine_, c, 8);
      machine_->submitter.run([&](VkCommandBuffer commands) { net.fair.record(commands); });
      std::vector<dvec3> made = result(net);
      for (std::size_t i = 0; i < made.size(); ++i) made[i] += c.given[net.records.owners[i]];
      const FairNet expected = c.net(8);
      ASSERT_EQ(made.size(), expected.state.size());
      for (std::size_t i = 0; i < made.size(); ++i)
        ASSERT_LT(glm::distance(made[i], expected.state[i]), kPoints) << i;
      const std::vector<dvec3> limits = limit_points(c.subdivision, made);
      for (std::size_t v = 0; v < limits.size(); ++v)
        EXPECT_LT(glm::distance(limits[v], c.given[v]), kLimits) << v;
    }
  }
};

TEST_P(FairHubs, Of1000EqualTheCpus) { equal_the_cpus(25); }
TEST_P(FairHubs, Of10000EqualTheCpus) { equal_the_cpus(250); }

INSTANTIATE_TEST_SUITE_P(Reads, FairHubs, both_reads(), name_of_reads);

}  // namespace
}  // namespace planish::testing
