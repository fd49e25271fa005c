#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "planish/fair/fair_net.h"
#include "planish/fair/fair_topology.h"
#include "planish/pipeline/fit.h"
#include "planish/surface/evaluate.h"
#include "support/calls.h"
#include "support/random_meshes.h"
#include "vulkan/fair_machine.h"

namespace planish::testing {
namespace {

// Fair nets built on the device against fair_net() in double.

using glm::dvec3;

// What exact nets leave in single precision before anything is rounded.
constexpr double kInterpolation = 9e-8;
// Root mean square angle between the normals of both surfaces, in degrees. Both go the same way but
// where a test decides by less than single precision knows; a net of few vertices then differs
// visibly at one of them.
constexpr double kNormals = 0.5;
// After the polish, whose conjugate gradients double what rounding does with every step on nets as
// folded as random ones; the mean over all meshes is below 0.02.
constexpr double kPolishedNormals = 1.0;

class FairNetOnDevice : public FairMachine {
 protected:
  static FairNet build(Backend& backend, const test::FairCase& c,
                       const FairOptions& options = {.polish_steps = 8}) {
    return dynamic_cast<FairBuilder&>(backend).build_fair_net(
        make_fair_topology(c.mesh, c.subdivision), c.given, options);
  }
};

double interpolation_error(const test::FairCase& c, std::span<const dvec3> state) {
  const std::vector<dvec3> limits = limit_points(c.subdivision, state);
  double worst = 0;
  for (std::size_t v = 0; v < limits.size(); ++v) {
    const double error = glm::distance(limits[v], c.given[v]);
    if (!(error <= worst)) worst = error;
  }
  return worst;
}

double distance_of_nets(const FairNet& a, const FairNet& b) {
  double worst = a.state.size() == b.state.size() ? 0 : HUGE_VAL;
  for (std::size_t i = 0; i < a.state.size(); ++i)
    worst = std::max(worst, glm::distance(a.state[i], b.state[i]));
  return worst;
}

double rms_normal_degrees(const test::FairCase& c, std::span<const dvec3> a,
                          std::span<const dvec3> b) {
  const test::LimitSamples first = test::limit_samples(c, a, 2);
  const test::LimitSamples second = test::limit_samples(c, b, 2);
  double sum = 0;
  std::int64_t count = 0;
  for (std::size_t i = 0; i < first.normals.size(); ++i) {
    const dvec3 n(first.normals[i]), m(second.normals[i]);
    if (n == dvec3(0.0) || m == dvec3(0.0)) continue;
    const double angle = std::atan2(glm::length(glm::cross(n, m)), glm::dot(n, m));
    sum += angle * angle;
    ++count;
  }
  return count ? std::sqrt(sum / double(count)) * 180 / M_PI : 0;
}

TEST_F(FairNetOnDevice, InterpolatesAndEqualsTheCpusSurface) {
  const auto backend = make_backend();
  double sum = 0;
  int count = 0;
  for (const test::NamedMesh& mesh : device_meshes()) {
    SCOPED_TRACE(mesh.name);
    const test::FairCase c(mesh.mesh, 2);
    for (const std::int32_t steps : {0, 8}) {
      const FairNet net = build(*backend, c, {.polish_steps = steps});
      const FairNet expected = c.net(steps);
      ASSERT_EQ(net.state.size(), expected.state.size());
      EXPECT_LT(interpolation_error(c, net.state), kInterpolation);
      const double degrees = rms_normal_degrees(c, net.state, expected.state);
      EXPECT_LT(degrees, steps > 0 ? kPolishedNormals : kNormals) << steps;
      sum += degrees;
      ++count;
    }
  }
  EXPECT_LT(sum / count, 0.02);
}

// Work groups run in any order, on hardware at once.
TEST_F(FairNetOnDevice, IsTheSameEveryTime) {
  for (const VulkanReads reads : {VulkanReads::StorageBuffers, VulkanReads::TexelBuffers}) {
    const auto backend = make_backend({.reads = reads});
    for (const test::NamedMesh& mesh : device_meshes()) {
      const test::FairCase c(mesh.mesh);
      const FairNet first = build(*backend, c);
      for (int i = 0; i < 3; ++i)
        EXPECT_EQ(distance_of_nets(build(*backend, c), first), 0) << mesh.name;
    }
  }
}

TEST_F(FairNetOnDevice, IsTheSameFromEitherKindOfReads) {
  const test::FairCase c(test::with_random_creases(test::random_open_mesh(5), 0.15, 6));
  const auto storage = make_backend({.reads = VulkanReads::StorageBuffers}),
             texel = make_backend({.reads = VulkanReads::TexelBuffers});
  EXPECT_LT(distance_of_nets(build(*storage, c), build(*texel, c)), 1e-5);
}

TEST_F(FairNetOnDevice, FitBuildsItThere) {
  const auto backend = make_backend();
  const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(5), 0.15, 6);
  const FitOptions options{.method = InterpolationMethod::Fair};
  const std::uint64_t before = backend->peak_device_bytes();
  const Fit made = fit(mesh, *backend, options);
  EXPECT_GT(backend->peak_device_bytes(), before);
  ASSERT_TRUE(made.fair.has_value());
  EXPECT_TRUE(made.interpolation.converged);
  EXPECT_LT(made.interpolation.error.max, kInterpolation);
  EXPECT_GT(made.interpolation.error.max, 1e-12);  // not the CPU's doubles
  const Fit expected = fit(mesh, *make_cpu_backend(), options);
  ASSERT_EQ(made.fair->level_one.state.size(), expected.fair->level_one.state.size());
  EXPECT_EQ(made.fair->flagged_edges, expected.fair->flagged_edges);
}

TEST_F(FairNetOnDevice, CountsWhatItDidLikeTheCpu) {
  const auto backend = make_backend();
  const test::FairCase c(test::delaunay_sphere(2000, 3));
  const FairNet net = build(*backend, c), expected = c.net(8);
  EXPECT_GT(expected.shrunk_vertices, 20);
  EXPECT_NEAR(net.shrunk_vertices, expected.shrunk_vertices, 2);
  EXPECT_NEAR(net.reversed_vertices, expected.reversed_vertices, 1);
  EXPECT_NEAR(net.flagged_edges, expected.flagged_edges, 1);
  EXPECT_NEAR(net.flagged_faces, expected.flagged_faces, 1);
}

TEST_F(FairNetOnDevice, KeepsDecisions) {
  const auto backend = make_backend();
  test::FairCase c(test::jittered(test::icosphere(3), 0.4, 1));
  const FairDecisions rest = c.net(8).decisions;
  ASSERT_GT(std::count(rest.late_halvings.begin(), rest.late_halvings.end(), 0), 0);
  for (dvec3& p : c.given) p = {p.x + 0.1 * p.y * p.y, 0.8 * p.y, p.z};  // another pose
  const FairOptions options{.polish_steps = 8, .decisions = &rest};
  const FairNet net = build(*backend, c, options);
  const FairNet expected = fair_net(c.mesh, c.subdivision, c.given, options);
  EXPECT_EQ(net.decisions.reversed, rest.reversed);
  EXPECT_EQ(net.decisions.halvings, rest.halvings);
  EXPECT_EQ(net.decisions.late_halvings, rest.late_halvings);
  EXPECT_EQ(net.decisions.cures, rest.cures);
  EXPECT_EQ(net.shrunk_vertices, expected.shrunk_vertices);
  EXPECT_EQ(net.reversed_vertices, expected.reversed_vertices);
  EXPECT_NEAR(net.flagged_edges, expected.flagged_edges, 2);
  EXPECT_NEAR(net.flagged_faces, expected.flagged_faces, 2);
  EXPECT_LT(distance_of_nets(net, expected), 1e-3);
  // What this pose would decide is something else.
  EXPECT_NE(build(*backend, c).decisions.halvings, rest.halvings);
}

TEST_F(FairNetOnDevice, KeepsPlanes) {
  const auto backend = make_backend();
  for (const PolygonMesh& mesh :
       {test::rounded_box({1, 0.7, 0.4}, 0.3, 4), test::plane_and_quarter_round(), test::slot(6)}) {
    const test::FairCase c(mesh, 2);
    const std::vector<KeptPlane> planes = kept_planes(c.mesh, c.subdivision);
    EXPECT_GT(planes.size(), 3U);
    const FairOptions options{.polish_steps = 8, .planes = planes};
    const FairNet net = build(*backend, c, options);
    const FairNet expected = fair_net(c.mesh, c.subdivision, c.given, options);
    EXPECT_EQ(net.decisions.planes, planes);
    EXPECT_LT(distance_of_nets(net, expected), 1e-5);
    EXPECT_GT(distance_of_nets(net, c.net(8)), 1e-3);
    const FairOptions decided{.polish_steps = 8, .decisions = &expected.decisions};
    EXPECT_LT(distance_of_nets(build(*backend, c, decided), expected), 1e-5);
  }
}

TEST_F(FairNetOnDevice, IsTheSameFromFewWorkGroups) {
  const test::FairCase c(test::delaunay_sphere(600, 1));
  const auto backend = make_backend(), limited = make_backend({.max_work_groups = 3});
  const FairNet a = build(*backend, c), b = build(*limited, c);
  EXPECT_LT(distance_of_nets(a, b), 1e-5);  // the sums of the polish run in another order
}

TEST_F(FairNetOnDevice, NamesTheLimitThatAMeshExceeds) {
  const test::FairCase c(test::delaunay_sphere(600, 1));
  const auto limited = make_backend({.max_storage_bytes = 32768});
  EXPECT_THAT(test::message_of(ErrorCode::OutOfMemory, [&] { build(*limited, c); }),
              ::testing::AllOf(::testing::HasSubstr("maxStorageBufferRange is 32768"),
                               ::testing::HasSubstr("--device cpu")));
}

TEST_F(FairNetOnDevice, SurvivesPointsThatCoincide) {
  const auto backend = make_backend();
  for (const double flat : {0.0, 1e-30}) {
    test::FairCase c(test::random_closed_mesh(3));
    for (std::size_t v = 0; v < c.given.size(); v += 2) c.given[v] = flat * c.given[v];
    const FairNet net = build(*backend, c);
    for (const dvec3& p : net.state)
      EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    EXPECT_LT(interpolation_error(c, net.state), kInterpolation);
  }
}

// Fair nets around hubs and large faces, whose walks work groups share, against those of the CPU.

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
