// The viewer's window on a display of the test's own: a second of frames, while somebody resizes
// it.
#include "viewer/window.h"

// clang-format off: before GLFW, which declares Vulkan's part only then
#include <GLFW/glfw3.h>
#include <vulkan/vulkan.h>
// clang-format on
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <optional>
#include <string>

#include "planish/core/error.h"
#include "support/environment_variable.h"
#include "support/meshes.h"
#include "viewer/fixture.h"
#include "viewer/swapchain.h"

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
