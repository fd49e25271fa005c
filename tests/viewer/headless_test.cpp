#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <iterator>

#include "cli/planish_process.h"
#include "planish/core/error.h"
#include "planish/job/page/render.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"
#include "viewer/arguments.h"
#include "viewer/fixture.h"
#include "viewer/headless.h"
#include "viewer/overlay.h"
#include "viewer/scene.h"

namespace planish::testing {
namespace {

// The viewer as a process: what it refuses, and what a run off-screen leaves.

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;

void expect_error(const std::vector<std::string>& arguments, int code, const std::string& part) {
  const test::ProcessResult result = test::run_planish(arguments);
  EXPECT_EQ(result.exit_code, code) << part;
  EXPECT_THAT(result.err, AllOf(StartsWith("planish-viewer: error: "), HasSubstr(part)));
}

TEST(ViewerArguments, HelpHasExamples) {
  const test::ProcessResult result = test::run_planish({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, AllOf(HasSubstr("Examples:"), HasSubstr("--headless")));
}

TEST(ViewerArguments, WhatIsWrongIsNamed) {
  expect_error({"--no-such-flag"}, 2, "--no-such-flag");
  expect_error({"--png", "a.png"}, 2, "--headless");
  expect_error({"--headless", "--frames", "0"}, 2, "--frames");
  expect_error({"--script", "a.txt"}, 2, "--headless");
  expect_error({"--headless", "--script", "a.txt", "--frames", "2"}, 2, "--frames");
  expect_error({"--headless", "--edit"}, 2, "--edit");
  expect_error({"--headless", "--iterations", "65"}, 2, "--iterations");
  expect_error({"--headless", "--level", "-1"}, 2, "--level");
  expect_error({"--headless", "--size", "10x10"}, 2, "--size 10x10");
  expect_error({"--headless", "--size", "100"}, 2, "--size 100");
  expect_error({"--headless", "--view", "nan,0"}, 2, "--view nan,0");
  expect_error({"--headless", "--view", "0,90"}, 2, "--view 0,90");
  expect_error({"--headless", "--scene", "missing.obj"}, 3, "missing.obj");
  expect_error({"--headless", "--scene", PLANISH_SCENES "/goblet.obj", "--job", "goblet"}, 2,
               "--job goblet");
  expect_error({"--headless", "--scene", PLANISH_SCENES "/goblet.json", "--job", "cup"}, 2, "cup");
  const auto points = std::filesystem::temp_directory_path() / "planish_viewer_points.xyz";
  std::ofstream(points) << "0 0 0\n1 0 0\n0 1 0\n";
  expect_error({"--headless", "--scene", points.string()}, 2, "planish reconstruct");
  std::filesystem::remove(points);
}

class ViewerProcess : public ViewerTest {};

TEST_F(ViewerProcess, Tessellates) {
  const test::ProcessResult result =
      test::run_planish({"--headless", "--scene", PLANISH_SCENES "/cube_with_windows.obj",
                         "--tessellate", "--size", "64x48", "--validate"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("tessellated on"), HasSubstr("validation: 0 messages")));
}

TEST_F(ViewerProcess, DrawsManyAtTheLevelsThatTheyNeed) {
  const std::string scene = PLANISH_SCENES "/cube_with_windows.obj";
  const test::ProcessResult result =
      test::run_planish({"--headless", "--scene", scene, "--instances", "50", "--frames", "2",
                         "--size", "64x48", "--validate"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("50 of cube_with_windows on"), HasSubstr(" at level 1\n"),
                                HasSubstr(" off screen\n"), HasSubstr("validation: 0 messages")));
  expect_error({"--scene", scene, "--instances", "50"}, 2, "--instances requires --headless");
  expect_error({"--headless", "--scene", PLANISH_SCENES "/goblet.obj", "--instances", "60000"}, 6,
               "choose fewer, or a smaller mesh");
}

TEST_F(ViewerProcess, WritesAPicture) {
  const auto path = std::filesystem::temp_directory_path() / "planish_viewer_test.png";
  const test::ProcessResult result =
      test::run_planish({"--headless", "--scene", PLANISH_SCENES "/cube_with_holes.obj", "--frames",
                         "5", "--size", "64x48", "--heat", "--validate", "--png", path.string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("5 frames"), HasSubstr("validation: 0 messages")));
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  EXPECT_THAT(bytes, StartsWith("\x89PNG"));
  std::filesystem::remove(path);
}

// A cube cut at its seams, by the fair method.
TEST_F(ViewerProcess, DrawsSquaresByTextureCoordinates) {
  const std::string scene = PLANISH_SCENES "/mapped_cube.obj";
  const test::ProcessResult result =
      test::run_planish({"--headless", "--scene", scene, "--texture", "--frames", "3", "--size",
                         "64x48", "--validate"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("validation: 0 messages"));
  expect_error({"--headless", "--scene", PLANISH_SCENES "/torus.obj", "--texture"}, 2,
               "--texture: torus has no texture coordinates");
}

TEST_F(ViewerProcess, DrawsAScriptOfMoves) {
  const auto folder = std::filesystem::temp_directory_path() / "planish_viewer_script";
  std::filesystem::create_directories(folder);
  const std::string script = (folder / "moves.txt").string(), mesh = (folder / "a.obj").string();
  std::ofstream(script) << "vertices 0\nradius 0.5\nmove 0 0 0.2 3\npicture "
                        << (folder / "a.png").string() << "\nsave mesh " << mesh << '\n';
  const std::string scene = PLANISH_SCENES "/torus.obj";
  const test::ProcessResult result = test::run_planish(
      {"--headless", "--scene", scene, "--script", script, "--size", "64x48", "--validate"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  // Within the tolerance of 1e-6.
  EXPECT_THAT(
      result.out,
      AllOf(ContainsRegex("5 steps, 4 frames; the surface is within [0-9.]+e-(0[7-9]|[1-9][0-9]) "),
            HasSubstr("validation: 0 messages")));
  EXPECT_TRUE(std::filesystem::exists(mesh));
  EXPECT_TRUE(std::filesystem::exists(folder / "a.png"));
  expect_error({"--headless", "--scene", scene, "--script", "missing.txt"}, 3, "missing.txt");
  std::ofstream(script) << "vertices 99999\n";
  expect_error({"--headless", "--scene", scene, "--script", script, "--size", "64x48"}, 2,
               script + ":1: there is no vertex 99999");
  std::ofstream(script) << "jump\n";
  expect_error({"--headless", "--scene", scene, "--script", script}, 2, script + ":1: 'jump'");
  std::filesystem::remove_all(folder);
}

TEST_F(ViewerProcess, SaysThatAPictureCannotBeWritten) {
  expect_error({"--headless", "--scene", PLANISH_SCENES "/cube.obj", "--size", "64x48", "--png",
                "/no/such/folder/a.png"},
               7, "/no/such/folder");
}

TEST_F(ViewerProcess, DevicesThatAreNotThereAreNamed) {
  expect_error({"--headless", "--scene", PLANISH_SCENES "/cube.obj", "--device", "abacus"}, 6,
               "'abacus'");
}

// What the viewer's frame loop leaves in its buffers, against the CPU; and what the validation
// layer says to many frames.

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

// The viewer's pictures, against the CPU's surface drawn by planish-render's rasteriser and shaded
// by a twin of surface.frag.

class PictureTest : public ViewerTest {
 protected:
  std::vector<std::uint8_t> picture_after(int frames, const PolygonMesh& rest,
                                          const HeadlessOptions& options) {
    return picture_after(frames, scene_of(rest), options);
  }
  std::vector<std::uint8_t> picture_after(int frames, const Scene& scene,
                                          const HeadlessOptions& options) {
    Headless headless(*device_, scene, options);
    headless.run(frames);
    return headless.picture();
  }
};

glm::ivec3 pixel(const std::vector<std::uint8_t>& picture, std::size_t index) {
  return {picture[3 * index], picture[3 * index + 1], picture[3 * index + 2]};
}

int distance(const glm::ivec3& a, const glm::ivec3& b) {
  const glm::ivec3 d = glm::abs(a - b);
  return std::max({d.x, d.y, d.z});
}

// The CPU's surface as one picture sees it.
struct Drawing {
  Drawing(const SurfaceMesh& mesh, std::vector<std::uint32_t> triangles,
          const HeadlessOptions& options)
      : surface(mesh),
        indices(std::move(triangles)),
        camera(options.camera),
        aspect(static_cast<float>(options.extent.width) /
               static_cast<float>(options.extent.height)),
        seen(static_cast<int>(options.extent.width), static_cast<int>(options.extent.height)) {
    const glm::vec2 half(0.5f * static_cast<float>(seen.width),
                         0.5f * static_cast<float>(seen.height));
    for (const glm::dvec3& p : surface.positions) {
      const glm::vec4 clip = camera.clip_from_world(aspect) * glm::vec4(glm::vec3(p), 1);
      projected.emplace_back((glm::vec2(clip) / clip.w + 1.0f) * half, 1 / clip.w);
    }
    render::rasterise(projected, indices, 0, seen.height, seen);
  }

  bool covers(int x, int y) const {
    return seen.what[seen.at(x, y)] != render::VisibilityBuffer::kNothing;
  }

  // Whether the surface goes on without a step around the pixel.
  bool is_inside(int x, int y) const {
    constexpr float kStep = 0.01f;
    const float here = seen.nearness[seen.at(x, y)];
    for (int j = y - 1; j <= y + 1; ++j)
      for (int i = x - 1; i <= x + 1; ++i)
        if (!covers(i, j) || std::abs(seen.nearness[seen.at(i, j)] - here) > kStep * here)
          return false;
    return true;
  }

  // Perspective-correct weights of a pixel's middle in the triangle that is seen there.
  glm::vec3 weights(int x, int y) const {
    const std::size_t first = 3 * std::size_t{seen.what[seen.at(x, y)]};
    const glm::vec2 p(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
    const auto corner = [&](int k) { return projected[indices[first + k]]; };
    const auto area = [](const glm::vec2& a, const glm::vec2& b) { return a.x * b.y - a.y * b.x; };
    glm::vec3 w;
    for (int k = 0; k < 3; ++k)
      w[k] = area(glm::vec2(corner((k + 1) % 3)) - p, glm::vec2(corner((k + 2) % 3)) - p) *
             corner(k).z;
    return w / (w.x + w.y + w.z);
  }

  glm::vec2 uv(int x, int y, std::span<const glm::vec2> uvs) const {
    const std::size_t first = 3 * std::size_t{seen.what[seen.at(x, y)]};
    const glm::vec3 w = weights(x, y);
    glm::vec2 sum(0);
    for (int k = 0; k < 3; ++k) sum += w[k] * uvs[indices[first + k]];
    return sum;
  }

  // As what is of that colour.
  glm::ivec3 shade(int x, int y, const glm::vec3& srgb = {0.82f, 0.80f, 0.77f}) const;

  const SurfaceMesh& surface;
  std::vector<std::uint32_t> indices;
  OrbitCamera camera;
  float aspect;
  render::VisibilityBuffer seen;
  std::vector<glm::vec3> projected;
};

// The twin of shade.glsl for front faces.
glm::ivec3 Drawing::shade(int x, int y, const glm::vec3& srgb) const {
  const std::size_t first = 3 * std::size_t{seen.what[seen.at(x, y)]};
  const glm::vec3 w = weights(x, y);
  glm::vec3 normal(0), position(0);
  for (int k = 0; k < 3; ++k) {
    normal += w[k] * surface.normals[indices[first + k]];
    position += w[k] * glm::vec3(surface.positions[indices[first + k]]);
  }
  normal = glm::normalize(normal);
  const glm::vec3 key = camera.key_light();
  const glm::vec3 to_eye = glm::normalize(camera.eye(aspect) - position);
  const glm::vec3 fill = glm::normalize(glm::vec3(-key.x, 0.25f, -key.z) + to_eye);
  const auto facing = [&](const glm::vec3& d) { return std::max(glm::dot(normal, d), 0.0f); };
  const glm::vec3 light = glm::mix(glm::vec3(0.10f, 0.09f, 0.09f), glm::vec3(0.24f, 0.27f, 0.32f),
                                   0.5f + 0.5f * normal.y) +
                          glm::vec3(0.86f, 0.82f, 0.75f) * facing(key) +
                          glm::vec3(0.13f, 0.16f, 0.20f) * facing(fill);
  const glm::vec3 clay = glm::pow(srgb, glm::vec3(2.2f));
  const float coat = 0.22f * std::pow(facing(glm::normalize(key + to_eye)), 48.0f) +
                     0.14f * std::pow(1 - facing(to_eye), 4.0f);
  glm::ivec3 shown;
  for (int k = 0; k < 3; ++k) {
    float value = clay[k] * light[k] + coat;
    if (value > 0.6f) value = 0.6f + 0.4f * (1 - std::exp((0.6f - value) / 0.4f));
    shown[k] = static_cast<int>(std::lround(255 * std::pow(value, 1 / 2.2f)));
  }
  return shown;
}

TEST_F(PictureTest, SurfaceIsTheCpusWhereItIsAndHowItIsLit) {
  for (const Scene& scene :
       {scene_of(test::torus(12, 7, 2, 0.7)), fair_scene_of(test::icosphere(1))}) {
    HeadlessOptions options = options_for(scene.mesh);
    options.settings.iterations = 20;
    const auto picture = picture_after(40, scene, options);
    options.settings.surface = false;
    const auto empty = picture_after(1, scene, options);
    const SurfaceMesh surface = surface_by_cpu(scene, posed(scene.mesh, 39));
    const vulkan::System system(scene.mesh, scene.system);
    const Drawing drawing(surface, {system.triangles().begin(), system.triangles().end()}, options);
    int inside = 0, outside = 0;
    for (int y = 1; y + 1 < drawing.seen.height; ++y)
      for (int x = 1; x + 1 < drawing.seen.width; ++x) {
        const std::size_t at = drawing.seen.at(x, y);
        bool any = false;
        for (int k = 0; k < 9; ++k) any = any || drawing.covers(x - 1 + k % 3, y - 1 + k / 3);
        if (!any) {
          ++outside;
          ASSERT_EQ(distance(pixel(picture, at), pixel(empty, at)), 0) << x << ' ' << y;
        } else if (drawing.is_inside(x, y)) {
          ++inside;
          // Two roundings to 8 bits, and the mean over samples of several triangles.
          ASSERT_LE(distance(pixel(picture, at), drawing.shade(x, y)), 3) << x << ' ' << y;
        }
      }
    EXPECT_GT(inside, 2000);
    EXPECT_GT(outside, 4000);
  }
}

// Squares lie where the System's texture coordinates have them, in their colours. Where the surface
// bulges over the outline of its mesh, these go past 0 and 1, too: squares go on, colours do not.
TEST_F(PictureTest, SquaresFollowTextureCoordinates) {
  PolygonMesh rest = test::flat_grid(6, 5);
  for (const glm::dvec3& p : rest.positions) rest.uvs.emplace_back(p.x / 6, p.y / 5);
  rest.face_uvs.assign(rest.face_vertices.begin(), rest.face_vertices.end());
  Scene scene = scene_of(rest);
  scene.system.textured = true;
  HeadlessOptions options = options_for(rest);
  options.extent = {480, 360};
  options.settings.iterations = 20;
  options.settings.texture = true;
  options.settings.tessellate = true;  // which shows at the level what it has no coordinates for
  const auto picture = picture_after(40, scene, options);
  const SurfaceMesh surface = surface_by_cpu(scene, posed(rest, 39));
  const vulkan::System system(scene.mesh, scene.system);
  const std::vector<glm::vec2> uvs = system.uvs();
  ASSERT_EQ(uvs.size(), surface.positions.size());
  const Drawing drawing(surface, {system.triangles().begin(), system.triangles().end()}, options);
  const auto square = [&](int x, int y) {
    return glm::ivec2(glm::floor(shared::kBoardSquares * drawing.uv(x, y, uvs)));
  };
  std::array<int, 2> seen{};  // dark and light ones
  for (int y = 1; y + 1 < drawing.seen.height; ++y)
    for (int x = 1; x + 1 < drawing.seen.width; ++x) {
      if (!drawing.is_inside(x, y)) continue;
      const glm::ivec2 at = square(x, y);
      bool is_whole = true;
      for (int k = 0; k < 9; ++k) is_whole &= square(x - 1 + k % 3, y - 1 + k / 3) == at;
      if (!is_whole) continue;
      const bool is_light = (at.x + at.y) % 2 != 0;
      const glm::vec2 uv = glm::clamp(drawing.uv(x, y, uvs), 0.0f, 1.0f);
      const glm::vec3 colour = is_light
                                   ? glm::vec3(0.86f)
                                   : glm::vec3(0.20f + 0.60f * uv.x, 0.30f, 0.20f + 0.60f * uv.y);
      ++seen[is_light ? 1 : 0];
      ASSERT_LE(distance(pixel(picture, drawing.seen.at(x, y)), drawing.shade(x, y, colour)), 4)
          << x << ' ' << y << ' ' << is_light;
    }
  EXPECT_GT(seen[0], 1000);
  EXPECT_GT(seen[1], 1000);
}

// Pixels of exactly that colour in the picture.
int count_of(const std::vector<std::uint8_t>& picture, const glm::vec3& colour) {
  const glm::ivec3 wanted(glm::round(255.0f * colour));
  int count = 0;
  for (std::size_t i = 0; i < picture.size() / 3; ++i)
    count += distance(pixel(picture, i), wanted) <= 1;
  return count;
}

TEST_F(PictureTest, ErrorColoursHaveALegendWithNumbers) {
  const PolygonMesh rest = test::torus(12, 7, 2, 0.7);
  HeadlessOptions options = options_for(rest);
  options.extent = {480, 360};
  options.settings.iterations = 1;
  options.settings.warm_start = false;
  const glm::vec3 ink = glm::vec3(30, 34, 42) / 255.0f;
  for (const bool heat : {false, true}) {
    options.settings.heat = heat;
    const auto picture = picture_after(10, rest, options);
    for (const std::size_t stop : {0, 1, 2, 3, 4})
      EXPECT_EQ(count_of(picture, shared::kHeatStops[stop]) > 10, heat) << stop;
    // Some 70 letters and digits of a dozen pixels each.
    EXPECT_EQ(count_of(picture, ink) > 700, heat);
  }
}

TEST(Legend, SaysHowItWasSolved) {
  using enum InterpolationMethod;
  EXPECT_EQ(solve_text(Progressive, 0), "0 iterations");
  EXPECT_EQ(solve_text(Progressive, 1), "1 iteration");
  EXPECT_EQ(solve_text(Progressive, 2), "2 iterations");
  EXPECT_EQ(solve_text(Fair, 6), "the fair method");
}

TEST_F(PictureTest, TogglesShowCageAndPoints) {
  const PolygonMesh rest = test::torus(12, 7, 2, 0.7);
  HeadlessOptions options = options_for(rest);
  options.extent = {480, 360};
  const glm::vec3 dot(0.82f, 0.20f, 0.10f), edge(0.10f, 0.28f, 0.52f);
  const auto plain = picture_after(2, rest, options);
  EXPECT_EQ(count_of(plain, dot), 0);
  EXPECT_EQ(count_of(plain, edge), 0);
  options.settings.cage = options.settings.points = true;
  const auto all = picture_after(2, rest, options);
  EXPECT_GT(count_of(all, dot), 100);
  EXPECT_GT(count_of(all, edge), 100);
}

}  // namespace
}  // namespace planish::testing
