// The viewer's window on a display of the test's own: a second of frames, while somebody resizes
// it.
#include "viewer/window.h"

// clang-format off: before GLFW, which declares Vulkan's part only then
#include <GLFW/glfw3.h>
// clang-format on
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "support/environment_variable.h"
#include "support/meshes.h"
#include "viewer/edit_session.h"
#include "viewer/fixture.h"
#include "viewer/x11_user.h"

namespace planish::testing {
namespace {

using namespace viewer;

// An X server without a screen, on a display number that it finds free.
class Xvfb {
 public:
  Xvfb() {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) return;
    const std::string number = std::to_string(ends[1]);
    const char* arguments[] = {"Xvfb",       "-displayfd", number.c_str(), "-screen", "0",
                               "640x480x24", "-nolisten",  "tcp",          nullptr};
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    for (const int output : {STDOUT_FILENO, STDERR_FILENO})
      posix_spawn_file_actions_addopen(&quiet, output, "/dev/null", O_WRONLY, 0);
    if (::posix_spawnp(&id_, "Xvfb", &quiet, nullptr, const_cast<char**>(arguments), environ) != 0)
      id_ = -1;
    posix_spawn_file_actions_destroy(&quiet);
    ::close(ends[1]);
    char digit = 0;
    while (::read(ends[0], &digit, 1) == 1 && digit != '\n') display_ += digit;
    ::close(ends[0]);
  }
  ~Xvfb() {
    if (id_ < 0) return;
    ::kill(id_, SIGTERM);
    ::waitpid(id_, nullptr, 0);
  }
  Xvfb(const Xvfb&) = delete;
  Xvfb& operator=(const Xvfb&) = delete;

  [[nodiscard]] bool runs() const { return !display_.empty(); }
  [[nodiscard]] std::string name() const { return ":" + display_; }

 private:
  pid_t id_ = -1;
  std::string display_;
};

class WindowTest : public ViewerTest {
 protected:
  void SetUp() override {
    ViewerTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    const char* required = std::getenv("PLANISH_REQUIRE_VULKAN");
    if (xvfb_.runs()) {
      display_.emplace("DISPLAY", xvfb_.name());
    } else if (required && std::string(required) == "1") {
      FAIL() << "no Xvfb; install the package xvfb";
    } else {
      GTEST_SKIP() << "no Xvfb";
    }
  }

  WindowOptions window_options(const PolygonMesh& mesh) {
    WindowOptions options;
    options.width = 200;
    options.height = 150;
    options.validation = true;
    options.message = [this](std::string_view message) {
      const std::lock_guard lock(mutex_);
      messages_.emplace_back(message);
    };
    options.camera = camera_around(mesh.positions);
    return options;
  }

  Xvfb xvfb_;
  std::optional<test::EnvironmentVariable> display_;
};

TEST_F(WindowTest, ShowsASecondOfFrames) {
  const PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  WindowOptions options = window_options(mesh);
  options.settings.heat = options.settings.cage = options.settings.points = true;
  const auto began = std::chrono::steady_clock::now();
  int calls = 0;
  options.before_frame = [&](GLFWwindow* window, int) {
    ++calls;
    if (std::chrono::steady_clock::now() - began > std::chrono::seconds(1) && calls > 60)
      glfwSetWindowShouldClose(window, GLFW_TRUE);
  };
  const WindowRun run = run_window(scene_of(mesh), options);
  EXPECT_GE(run.frames, 60);
  EXPECT_GE(run.seconds, 0.9);
}

TEST_F(WindowTest, DragsAPointAndSavesIt) {
  const auto folder = std::filesystem::temp_directory_path() / "planish_viewer_window";
  std::filesystem::create_directories(folder);
  const PolygonMesh mesh = test::torus(24, 12, 2, 0.7);
  WindowOptions options = window_options(mesh);
  options.width = 600;
  options.height = 400;
  options.edits = true;
  options.save = (folder / "edited").string();
  options.settings.iterations = 2;
  options.frames = 48;
  std::unique_ptr<X11User> user;
  // A point that is seen beside the panel, which takes the upper left.
  const float aspect = 1.5f;
  int x = 0, y = 0;
  viewer::Scene scene = scene_of(mesh);
  EditSession session(scene);
  EditHand hand(session);
  for (std::int32_t v = 0; v < mesh.vertex_count() && x == 0; ++v) {
    const glm::vec2 at = *options.camera.place_of(mesh.positions[v], aspect);
    if (at.x < 0.6f || hand.vertex_at(options.camera, aspect, at) != v) continue;
    x = static_cast<int>(std::lround(600 * at.x));
    y = static_cast<int>(std::lround(400 * at.y));
  }
  ASSERT_GT(x, 0);
  options.before_frame = [&](GLFWwindow* window, int frame) {
    if (frame == 0) {
      user = std::make_unique<X11User>(window);
      glfwFocusWindow(window);
    }
    if (frame == 4) user->point_at(x, y);
    if (frame == 8) user->left_button(true);
    if (frame >= 12 && frame < 20) user->point_at(x + frame - 11, y + 2 * (frame - 11));
    if (frame == 24) user->left_button(false);
    if (frame == 28) user->key("Control_L", true);
    if (frame == 30) user->key("s", true);
    if (frame == 34) user->key("s", false);
    if (frame == 36) user->key("Control_L", false);
    if (frame == 46) user.reset();
  };
  EXPECT_EQ(run_window(scene_of(mesh), options).frames, 48);
  const PolygonMesh saved = read_mesh(options.save + ".obj").mesh;
  ASSERT_EQ(saved.vertex_count(), mesh.vertex_count());
  int moved = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (saved.positions[v] == mesh.positions[v]) continue;
    ++moved;
    const glm::vec2 from = *options.camera.place_of(mesh.positions[v], aspect),
                    to = *options.camera.place_of(saved.positions[v], aspect);
    EXPECT_NEAR(600 * (to - from).x, 8, 0.6);
    EXPECT_NEAR(400 * (to - from).y, 16, 0.6);
  }
  EXPECT_EQ(moved, 1);
  std::filesystem::remove_all(folder);
}

TEST_F(WindowTest, FollowsItsSize) {
  const PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  WindowOptions options = window_options(mesh);
  options.frames = 24;
  int width = 0, height = 0;
  options.before_frame = [&](GLFWwindow* window, int frame) {
    if (frame == 8) glfwSetWindowSize(window, 320, 90);
    if (frame == 16) glfwSetWindowSize(window, 40, 240);
    glfwGetFramebufferSize(window, &width, &height);
  };
  EXPECT_EQ(run_window(scene_of(mesh), options).frames, 24);
  EXPECT_EQ(width, 40);
  EXPECT_EQ(height, 240);
}

TEST_F(WindowTest, WithoutADisplaySaysWhatToDo) {
  const test::EnvironmentVariable nowhere("DISPLAY", ":63999");
  const PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  try {
    run_window(scene_of(mesh), window_options(mesh));
    FAIL() << "showed a window";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::NoDevice);
    EXPECT_NE(std::string(error.what()).find("--headless"), std::string::npos) << error.what();
  }
}

TEST(SwapchainExtent, FollowsTheSurfaceOrTheFramebufferAndIsNothingWhenMinimised) {
  VkSurfaceCapabilitiesKHR surface{};
  surface.minImageExtent = {10, 10};
  surface.maxImageExtent = {1000, 1000};
  surface.currentExtent = {300, 200};
  EXPECT_EQ(swapchain_extent(surface, {50, 60})->width, 300u);
  surface.currentExtent = {0, 0};
  EXPECT_FALSE(swapchain_extent(surface, {50, 60}));
  surface.currentExtent = {0xffffffff, 0xffffffff};
  EXPECT_FALSE(swapchain_extent(surface, {0, 0}));
  EXPECT_EQ(swapchain_extent(surface, {5000, 60})->width, 1000u);
  EXPECT_EQ(swapchain_extent(surface, {5000, 60})->height, 60u);
  EXPECT_EQ(swapchain_extent(surface, {500, 2})->height, 10u);
}

}  // namespace
}  // namespace planish::testing
