#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "planish/vulkan/device/own_device.h"
#include "vulkan/embedding.h"
#include "vulkan/fixture.h"
#include "vulkan/pretended_driver.h"

namespace planish::testing {

/// A host with its device, on a driver that counts and pretends. Any message of the validation
/// layer fails the test, and so does what is left alive.
class Embedding : public VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    PretendedDriver::reset();
    open();
  }

  void TearDown() override {
    close();
    EXPECT_TRUE(PretendedDriver::alive().empty());
    for (const std::string& rule : PretendedDriver::broken_rules()) ADD_FAILURE() << rule;
    VulkanTest::TearDown();
  }

  vulkan::OwnDeviceOptions device_options() {
    vulkan::OwnDeviceOptions options;
    options.wanted = test::wanted_device();
    options.instance.get_proc = PretendedDriver::get_proc();
    options.instance.validation = validation_wanted();
    options.instance.message = [this](std::string_view message) {
      const std::lock_guard lock(mutex_);
      messages_.emplace_back(message);
    };
    return options;
  }

  void open(const vulkan::ContextOptions& options = {}) {
    close();
    own_ = std::make_unique<vulkan::OwnDevice>(device_options());
    context_ = std::make_unique<vulkan::Context>(*own_, options);
    submitter_ = std::make_unique<vulkan::Submitter>(*context_, own_->queue(),
                                                     own_->capabilities().compute_family);
  }

  /// With a context of each variant of the kernels.
  template <class Work>
  void with_both_variants(const Work& work) {
    for (const vulkan::PipelineVariant& variant :
         {vulkan::kSoftwareVariant, vulkan::kHardwareVariant}) {
      open({.variant = variant});
      work();
    }
  }

  void close() {
    submitter_.reset();
    context_.reset();
    own_.reset();
  }

  /// Gives the points, runs solve, evaluation and status, and fetches the vertices.
  std::vector<Vertex> run(HostFrame& frame, const PolygonMesh& pose,
                          const vulkan::SolveParameters& parameters) {
    frame.set_points(pose);
    submitter_->run([&](VkCommandBuffer commands) { frame.record(commands, parameters); });
    return frame.vertices();
  }

  std::unique_ptr<vulkan::OwnDevice> own_;
  std::unique_ptr<vulkan::Context> context_;
  std::unique_ptr<vulkan::Submitter> submitter_;
};

[[nodiscard]] inline vulkan::SolveParameters iterations(std::uint32_t count) {
  vulkan::SolveParameters parameters;
  parameters.iterations = count;
  parameters.measures_last = true;
  return parameters;
}

}  // namespace planish::testing
