// What a System says of its rest pose and of iterations, without a device.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <string_view>
#include <tuple>

#include "planish/core/error.h"
#include "planish/solve/backend.h"
#include "planish/solve/iteration.h"
#include "planish/surface/evaluate.h"
#include "planish/vulkan/embed.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding.h"

namespace planish::testing {
namespace {

using namespace vulkan;

/// Errors before step 0, 1, ... of a pose.
std::vector<double> errors_of(const System& system, const PolygonMesh& pose) {
  std::vector<glm::dvec3> given;
  for (const std::int32_t v : system.used_vertices()) given.push_back(pose.positions[v]);
  const auto backend = make_cpu_backend();
  const auto solve = backend->make_solve(system.limit_masks());
  solve->begin(initial_residual(system.limit_masks(), given));
  std::vector<double> errors;
  for (const ErrorNorms& error :
       solve->run(chebyshev_steps(system.spectral_bound(), 80), -1).errors)
    errors.push_back(error.max);
  return errors;
}

TEST(System, CountsTheStepsOfItsRestPose) {
  for (std::uint32_t seed = 1; seed < 6; ++seed) {
    const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(seed), 0.1, seed);
    const System system(mesh);
    const std::vector<double> errors = errors_of(system, mesh);
    EXPECT_NEAR(system.rest_error(), errors[0], 1e-12);
    const std::uint32_t count = system.rest_iterations();
    ASSERT_GT(count, 0u);
    EXPECT_LE(errors[count], system.tolerance() * (1 + 1e-9)) << seed;
    EXPECT_GT(errors[count - 1], system.tolerance()) << seed;
  }
}

TEST(System, RefusesFacesThatIterationsCannotTake) {
  const PolygonMesh drum = test::prism(5000);
  try {
    const System system(drum);
    FAIL() << "was made";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnusableMesh);
    EXPECT_NE(std::string_view(error.what()).find("the largest face, 0, has 5000 corners"),
              std::string_view::npos)
        << error.what();
  }
  SystemOptions fair;
  fair.method = InterpolationMethod::Fair;
  EXPECT_EQ(System(drum, fair).given_count(), drum.vertex_count());
}

TEST(System, TellsWhatItsCopiesStandFor) {
  for (const int level : {0, 1, 2}) {
    PolygonMesh mesh = test::with_random_creases(test::random_closed_mesh(3), 0.2, 3);
    mesh.positions.insert(mesh.positions.begin(), glm::dvec3(9, 9, 9));  // unused
    for (auto& v : mesh.face_vertices) ++v;
    for (CreaseEdge& crease : mesh.creases) ++crease.v0, ++crease.v1;
    SystemOptions options;
    options.level = level;
    const System system(mesh, options);
    const auto copied = system.copied_vertices();
    ASSERT_EQ(copied.size(), static_cast<std::size_t>(system.vertex_count()));
    const SurfaceMesh surface = evaluate(mesh, *make_cpu_backend(), {.level = level});
    ASSERT_EQ(copied.size(), surface.positions.size());
    // Only copies lie where another vertex does.
    const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
      return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    };
    std::map<glm::dvec3, std::int32_t, decltype(less)> first(less);
    std::size_t copies = 0, of_given = 0;
    for (std::size_t i = 0; i < copied.size(); ++i) {
      const auto [place, is_new] =
          first.try_emplace(surface.positions[i], static_cast<std::int32_t>(i));
      EXPECT_EQ(copied[i], place->second) << i;
      if (is_new) continue;
      ++copies;
      of_given += static_cast<std::size_t>(copied[i]) < system.used_vertices().size();
    }
    EXPECT_GT(of_given, 0u);
    if (level > 0) {
      EXPECT_GT(copies, of_given);
    }
  }
}

TEST(System, SufficientIterationsSuffice) {
  for (std::uint32_t seed = 1; seed < 8; ++seed)
    for (const bool closed : {true, false}) {
      const PolygonMesh mesh =
          closed ? test::random_closed_mesh(seed)
                 : test::with_random_creases(test::random_open_mesh(seed), 0.2, seed);
      for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
        SystemOptions options;
        options.weights = weights;
        options.level = 0;
        const System system(mesh, options);
        for (int frame = 0; frame < 4; ++frame) {
          const std::vector<double> errors = errors_of(system, posed(mesh, frame));
          const std::uint32_t count = system.sufficient_iterations(errors[0]);
          ASSERT_LT(count, errors.size());
          EXPECT_LE(errors[count], system.tolerance()) << seed << " " << closed;
        }
        EXPECT_LE(system.rest_iterations(), system.sufficient_iterations(system.rest_error()));
      }
    }
}

TEST(System, NeedsNoIterationWithinItsTolerance) {
  const System system(test::icosphere(1));
  EXPECT_EQ(system.sufficient_iterations(0), 0u);
  EXPECT_EQ(system.sufficient_iterations(system.tolerance()), 0u);
  EXPECT_GT(system.sufficient_iterations(2 * system.tolerance()), 0u);
}

TEST(System, RefusesWhatItCannotBeMadeOf) {
  EXPECT_THROW(System(test::cube(), {.level = 7}), Error);
  EXPECT_THROW(System(test::cube(), {.tolerance = 0}), Error);
  PolygonMesh broken = test::cube();
  broken.face_vertices[0] = 99;
  try {
    const System system(broken);
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnusableMesh);
  }
}

}  // namespace
}  // namespace planish::testing
