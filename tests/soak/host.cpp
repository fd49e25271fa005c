#include <cstdio>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <memory>
#include <mutex>
#include <random>
#include <string_view>

#include "planish/core/error.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/device/own_device.h"
#include "planish/vulkan/vulkan_backend.h"
#include "soak/soak.h"
#include "support/environment_variable.h"
#include "support/random_meshes.h"
#include "vulkan/embedding.h"
#include "vulkan/pretended_driver.h"

namespace planish::test {
namespace {

using testing::HostFrame;
using testing::HostTopology;
using testing::PretendedDriver;

constexpr std::uint64_t kHostMayGrow = 16u << 20;
constexpr int kFrames = 12;         // of a topology
constexpr double kOffGiven = 2e-5;  // of the diagonal, single precision through a solve

PolygonMesh mesh_by_lot(std::mt19937& random) {
  const auto seed = static_cast<std::uint32_t>(random() % 40);
  switch (random() % 4) {
    case 0:
      return random_closed_mesh(seed);
    case 1:
      return with_random_creases(random_open_mesh(seed), 0.15, seed);
    case 2:
      return torus(9 + static_cast<int>(random() % 20), 7, 2, 0.7);
    default:
      return random_open_mesh(seed);
  }
}

class Session {
 public:
  explicit Session(std::mt19937& random) : random_(random) {
    vulkan::OwnDeviceOptions options;
    options.instance.get_proc = PretendedDriver::get_proc();
    options.instance.validation = true;
    options.instance.message = [this](std::string_view message) {
      const std::lock_guard lock(mutex_);
      complain("validation: " + std::string(message));
    };
    own_ = std::make_unique<vulkan::OwnDevice>(options);
    context_ = std::make_unique<vulkan::Context>(*own_);
    submitter_ = std::make_unique<vulkan::Submitter>(*context_, own_->queue(),
                                                     own_->capabilities().compute_family);
  }

  // Another topology at another level; frames of changing layouts and parameters.
  void draw() {
    const PolygonMesh rest = mesh_by_lot(random_);
    vulkan::SystemOptions options;
    options.level = static_cast<int>(random_() % 3);
    const bool is_fair = random_() % 2 == 0;
    if (is_fair) options.method = InterpolationMethod::Fair;
    const HostTopology topology(*context_, *submitter_, rest, options);
    std::unique_ptr<HostFrame> frame;
    for (int i = 0; i < kFrames; ++i) {
      if (i % 4 == 0) frame = frame_by_lot(topology);  // as when a window's buffers are made anew
      const PolygonMesh pose = testing::posed(rest, i);
      frame->set_points(pose);
      vulkan::SolveParameters parameters;
      parameters.iterations = 40;
      parameters.measures_last = true;
      parameters.warm_start = i % 4 != 0 && random_() % 2 == 0;
      submitter_->run([&](VkCommandBuffer commands) { frame->record(commands, parameters); });
      check(*frame, topology, pose);
    }
  }

 private:
  std::unique_ptr<HostFrame> frame_by_lot(const HostTopology& topology) {
    testing::Layout layout;
    if (random_() % 2)
      layout = {.offset = 256, .stride = 40, .position_offset = 4, .normal_offset = 20};
    return std::make_unique<HostFrame>(*context_, topology, layout, 1,
                                       40 + static_cast<std::uint32_t>(random_() % 20));
  }

  void check(HostFrame& frame, const HostTopology& topology, const PolygonMesh& pose) const {
    const std::vector<testing::Vertex> vertices = frame.vertices();
    const std::span<const std::int32_t> used = topology.system.used_vertices();
    double largest = 0;
    for (std::size_t i = 0; i < used.size(); ++i) {
      const double off = glm::distance(glm::dvec3(vertices[i].position), pose.positions[used[i]]);
      largest = off <= largest ? largest : off;  // NaN stays
    }
    if (!(largest <= kOffGiven * topology.system.diagonal()))
      complain("a frame leaves a given point by " + std::to_string(largest));
  }

  std::mt19937& random_;
  std::mutex mutex_;
  std::unique_ptr<vulkan::OwnDevice> own_;
  std::unique_ptr<vulkan::Context> context_;
  std::unique_ptr<vulkan::Submitter> submitter_;
};

}  // namespace

bool soak_host(std::uint32_t count, std::uint32_t first) {
  if (const VulkanDeviceList list = list_vulkan_devices(); list.best < 0) {
    std::fprintf(stderr, "no Vulkan device: %s\n", list.reason.c_str());
    const char* required = std::getenv("PLANISH_REQUIRE_VULKAN");
    if (required && std::string_view(required) == "1") complain("a device is required");
    return complaints() > 0;
  }
  const EnvironmentVariable enables(
      "VK_LAYER_ENABLES",
      "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT:"
      "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT");
  Growth growth;
  int lost = 0;
  std::uint32_t i = first;
  for (; i - first < count && !is_stopped(); ++i) {
    std::mt19937 random(i);
    PretendedDriver::reset();
    try {
      Session session(random);
      const bool loses = random() % 3 == 0;
      session.draw();
      if (loses)
        PretendedDriver::pretence().submissions_left = static_cast<int>(random() % kFrames);
      session.draw();
      if (loses) complain("a lost device was not told of");
    } catch (const vulkan::VulkanError& error) {
      if (error.code() != ErrorCode::DeviceLost) complain(error.what());
      ++lost;
    } catch (const Error& error) {
      complain(error.what());
    }
    if (!PretendedDriver::alive().empty()) complain("something is left alive");
    growth.note(resident_bytes());
  }
  std::printf("%u sessions, %d of them lost their device; resident %s\n", i - first, lost,
              growth.text().c_str());
  if (growth.bytes() > kHostMayGrow)
    complain("memory grows by " + std::to_string(growth.bytes()) + " bytes");
  return true;
}

}  // namespace planish::test
