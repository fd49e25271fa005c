// What the viewer's frame loop leaves in its buffers, against the CPU; and what the validation
// layer says to many frames.
#include "viewer/headless.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "planish/core/error.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"
#include "viewer/fixture.h"
#include "viewer/scene.h"

namespace planish::testing {
namespace {

using namespace viewer;

// Single precision of coordinates of a few units.
constexpr double kRounding = 2e-6;

class HeadlessTest : public ViewerTest {};

// Distances of the given points from the surface after so many iterations, in double.
std::vector<double> errors_by_cpu(const PolygonMesh& mesh, int iterations) {
  const auto backend = make_cpu_backend();
  FitOptions options;
  options.tolerance = 1e-15;
  options.max_iterations = iterations;
  const Fit fitted = fit(mesh, *backend, options);
  const auto limits = limit_positions(fitted.cage, options.weights, options.sharp);
  std::vector<double> errors;
  for (std::size_t i = 0; i < limits.size(); ++i)
    errors.push_back(glm::distance(limits[i], mesh.positions[i]));
  return errors;
}

TEST_F(HeadlessTest, ErrorsOfGivenPointsAreTheCpus) {
  const PolygonMesh rest = test::torus(12, 7, 2, 0.7);
  for (const int iterations : {0, 3}) {
    HeadlessOptions options = options_for(rest);
    options.settings.iterations = iterations;
    options.settings.warm_start = false;
    options.settings.heat = true;  // or no error is measured
    Headless headless(*device_, scene_of(rest), options);
    headless.run(30);
    const std::vector<double> expected = errors_by_cpu(posed(rest, 29), iterations);
    const auto vertices = headless.vertices();
    ASSERT_GT(vertices.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      ASSERT_NEAR(vertices[i].error, expected[i], kRounding) << i;
    EXPECT_NEAR(headless.status().residual, *std::ranges::max_element(expected), kRounding);
    EXPECT_GT(headless.status().residual, 100 * kRounding);  // so that something was compared
  }
}

TEST_F(HeadlessTest, WarmFramesFollowTheAnimation) {
  const PolygonMesh rest = test::torus(12, 7, 2, 0.7);
  HeadlessOptions options = options_for(rest);
  options.settings.iterations = 3;
  double residual[2];
  for (const bool warm : {false, true}) {
    options.settings.warm_start = warm;
    Headless headless(*device_, scene_of(rest), options);
    headless.run(30);
    residual[warm] = headless.status().residual;
  }
  EXPECT_LT(residual[1], 0.5 * residual[0]);
}

TEST_F(HeadlessTest, AnotherLevelIsBuiltWhileFramesAreInFlight) {
  const PolygonMesh rest = test::torus(9, 6, 2, 0.7);
  const OwnedRenderPass pass =
      make_render_pass(*device_, {VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
  Renderer renderer(*device_, pass, scene_of(rest));
  const ViewSettings settings;
  for (const int level : {2, 0, 0, 3}) {
    renderer.prepare(level);
    renderer.begin_frame(0, settings);
    renderer.end_frame();
  }
  renderer.finish();
  EXPECT_EQ(renderer.system().level(), 3);
  EXPECT_LT(renderer.status()->residual, 0.1);
}

TEST_F(HeadlessTest, TwoHundredFramesOfTheGobletAreValid) {
  Scene scene = load_scene(PLANISH_SCENES "/goblet.json", "");
  HeadlessOptions options = options_for(scene.mesh);
  options.extent = {80, 60};
  options.settings.level = 2;
  options.settings.heat = options.settings.cage = options.settings.points = true;
  Headless headless(*device_, std::move(scene), options);
  headless.run(200);
  EXPECT_LT(headless.status().residual, 1e-5 * headless.system().diagonal());
  EXPECT_EQ(headless.picture().size(), 3u * 80 * 60);
}

// What they hold, errors and pictures show.
TEST_F(HeadlessTest, TablesAreInTheDevicesOwnMemory) {
  const std::vector<std::uint32_t> words{7, 11, 13};
  EXPECT_EQ(word_buffer(*device_, words).mapped().data(), nullptr);
}

// Silence above means something only if the layers speak.
TEST_F(HeadlessTest, LayersReportAHazard) {
  const Buffer buffer(*device_, 64, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Device);
  device_->run([&](VkCommandBuffer commands) {
    vkCmdFillBuffer(commands, buffer, 0, 64, 1);
    vkCmdFillBuffer(commands, buffer, 0, 64, 2);
  });
  EXPECT_THAT(messages_, ::testing::Contains(::testing::HasSubstr("WRITE_AFTER_WRITE")));
  messages_.clear();
}

TEST_F(HeadlessTest, DevicesThatAreNotThereAreNamed) {
  try {
    const Device device(*instance_, {"no such device"});
    FAIL() << "made a device";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::NoDevice);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("'no such device'"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("0 '" + device_->name()));
  }
}

}  // namespace
}  // namespace planish::testing
