// Surfaces of least bending in a host's command buffers, against bend_least() on the CPU.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <random>

#include "planish/core/error.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;
using ::testing::HasSubstr;

using EmbedWithin = Embedding;

constexpr double kWithin = 2e-3;  // of the diagonal
// Of the diagonal: single precision, and 30 steps that carry it on.
constexpr double kWithinRounding = 3e-6;

PolygonMesh with_noise(PolygonMesh mesh, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, size);
  for (glm::dvec3& p : mesh.positions)
    p += glm::dvec3(normal(random), normal(random), normal(random));
  return mesh;
}

// The worst distance of limit points of used vertices, which come first, from `points`.
double worst_distance(const System& system, const std::vector<Vertex>& vertices,
                      std::span<const glm::dvec3> points) {
  double worst = 0;
  for (std::size_t i = 0; i < system.used_vertices().size(); ++i) {
    const double distance =
        glm::distance(glm::dvec3(vertices[i].position), points[system.used_vertices()[i]]);
    if (!(distance <= worst)) worst = distance;
  }
  return worst;
}

std::vector<test::NamedMesh> noisy_meshes() {
  PolygonMesh unused = with_noise(test::torus(18, 10, 2, 0.7), 0.006, 5);
  unused.positions.insert(unused.positions.begin() + 20, glm::dvec3(1, 0, 0));
  for (std::int32_t& v : unused.face_vertices) v += v >= 20;
  return {{"icosphere", with_noise(test::icosphere(2), 0.004, 1)},
          {"torus", with_noise(test::torus(18, 10, 2, 0.7), 0.006, 2)},
          {"creases",
           with_noise(test::with_random_creases(test::random_open_mesh(5), 0.15, 6), 0.004, 4)},
          {"unused vertex", unused}};
}

// To where the mesh bends least, whatever its surface does.
std::vector<glm::dvec3> moved_points(const PolygonMesh& mesh, const FitOptions& wanted) {
  FitOptions exact = wanted;
  exact.within = 0.0;
  const Fit fitted = fit(mesh, *make_cpu_backend(), exact);
  const UsedPart used = used_part(mesh, fitted.prepared);
  std::vector<glm::dvec3> unit;
  for (const glm::dvec3& p : used.mesh.positions) unit.push_back(fitted.placement.to_unit(p));
  const auto within =
      bend_least(*fitted.prepared->topology, *fitted.features, fitted.placement, wanted, unit);
  EXPECT_GT(within->at_bound, 0);
  std::vector<glm::dvec3> moved = mesh.positions;
  for (std::size_t v = 0; v < unit.size(); ++v)
    moved[used.vertices[v]] = fitted.placement.to_model(unit[v]);
  return moved;
}

TEST_F(EmbedWithin, PointsAreMovedToWhereTheMeshBendsLeast) {
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant}) {
    ContextOptions on;
    on.variant = variant;
    open(on);
    for (const test::NamedMesh& mesh : noisy_meshes())
      for (const InterpolationMethod method :
           {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
        SCOPED_TRACE(mesh.name + (method == InterpolationMethod::Fair ? " fair" : ""));
        SystemOptions options;
        options.level = 0;
        options.method = method;
        options.within = kWithin;
        HostTopology topology(*context_, mesh.mesh, options);
        topology.upload(*submitter_);
        HostFrame frame(*context_, topology);
        const std::vector<Vertex> vertices = run(frame, mesh.mesh, iterations(40));

        FitOptions wanted;
        wanted.method = method;
        wanted.within = kWithin;
        const double diagonal = topology.system.diagonal();
        EXPECT_DOUBLE_EQ(topology.system.within(), kWithin * diagonal);
        EXPECT_LT(worst_distance(topology.system, vertices, moved_points(mesh.mesh, wanted)),
                  kWithinRounding * diagonal);
        const double off = worst_distance(topology.system, vertices, mesh.mesh.positions);
        EXPECT_LT(off, (kWithin + kWithinRounding) * diagonal);
        EXPECT_GT(off, 0.9 * kWithin * diagonal);
        EXPECT_LT(frame.status().residual, 2e-6 * diagonal);
      }
  }
}

// Turned and moved, a pose's points move as the rest pose's.
TEST_F(EmbedWithin, PosesMoveWithTheirMesh) {
  const PolygonMesh rest = noisy_meshes()[0].mesh;
  SystemOptions options;
  options.level = 0;
  options.within = kWithin;
  HostTopology topology(*context_, rest, options);
  topology.upload(*submitter_);
  HostFrame frame(*context_, topology);
  const std::vector<Vertex> there = run(frame, rest, iterations(40));
  PolygonMesh pose = rest;
  for (glm::dvec3& p : pose.positions) p = glm::dvec3(-p.y + 3, p.x - 1, p.z + 2);
  std::vector<glm::dvec3> expected(rest.positions.size());
  for (std::size_t i = 0; i < there.size(); ++i) {
    const glm::dvec3 p(there[i].position);
    expected[topology.system.used_vertices()[i]] = {-p.y + 3, p.x - 1, p.z + 2};
  }
  EXPECT_LT(worst_distance(topology.system, run(frame, pose, iterations(40)), expected),
            kWithinRounding * topology.system.diagonal());
}

TEST_F(EmbedWithin, InstancesHaveTheBitsOfTheirOwn) {
  constexpr std::uint32_t kCount = 3;
  const PolygonMesh rest = noisy_meshes()[1].mesh;
  SystemOptions options;
  options.within = kWithin;
  HostTopology topology(*context_, rest, options);
  topology.upload(*submitter_);
  HostFrame together(*context_, topology, {}, 64, kCount), alone(*context_, topology);
  for (std::uint32_t i = 0; i < kCount; ++i)
    together.set_points(with_noise(posed(rest, static_cast<int>(i)), 0.004, i), i);
  submitter_->run([&](VkCommandBuffer commands) { together.record(commands, iterations(40)); });
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const std::vector<Vertex> expected =
        run(alone, with_noise(posed(rest, static_cast<int>(i)), 0.004, i), iterations(40));
    const std::vector<Vertex> found = together.vertices(i);
    EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof(Vertex)), 0) << i;
  }
}

TEST_F(EmbedWithin, NoiseOfTheRestPoseIsMeasured) {
  const PolygonMesh rest = with_noise(test::torus(48, 24, 2, 0.7), 0.004, 8);
  SystemOptions options;
  options.within.reset();
  const System measured(rest, options);
  FitOptions wanted;
  wanted.within.reset();
  const Fit expected = fit(rest, *make_cpu_backend(), wanted);
  EXPECT_DOUBLE_EQ(measured.within(), expected.within->within * measured.diagonal());
  EXPECT_GT(measured.within(), 0.003);
}

TEST_F(EmbedWithin, NothingIsMovedWhereNothingMayMove) {
  const PolygonMesh rest = noisy_meshes()[0].mesh;
  SystemOptions options;
  options.within = options.tolerance;
  EXPECT_EQ(System(rest, options).within(), 0);
  EXPECT_EQ(System(rest, options).bending_records(), nullptr);
  for (const double wrong : {-1e-3, 0.1, double(NAN)}) {
    options.within = wrong;
    try {
      const System system(rest, options);
      ADD_FAILURE() << wrong;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_THAT(error.what(), HasSubstr("is outside 0 to 0.1 of the diagonal"));
    }
  }
}

}  // namespace
}  // namespace planish::testing
