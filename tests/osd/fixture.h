#pragma once

#include <memory>

#include "planish/osd/vk_device_context.h"
#include "planish/vulkan/own_device.h"
#include "vulkan/fixture.h"

namespace planish::testing {

/// A device with validation and synchronization validation, and what OpenSubdiv's classes need.
class OsdTest : public VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    vulkan::OwnDeviceOptions options;
    options.instance.validation = true;
    options.instance.message = [this](std::string_view message) {
      const std::lock_guard lock(mutex_);
      messages_.emplace_back(message);
    };
    device_ = std::make_unique<vulkan::OwnDevice>(options);
    make_context({});
  }

  void TearDown() override {
    device_context_.reset();
    context_.reset();
    device_.reset();
    VulkanTest::TearDown();
  }

  void make_context(const vulkan::ContextOptions& options) {
    device_context_.reset();
    context_ = std::make_unique<vulkan::Context>(device_->host_device(), options);
    device_context_ = make_device_context();
  }

  std::unique_ptr<osd::VkDeviceContext> make_device_context() {
    return std::make_unique<osd::VkDeviceContext>(*context_, device_->queue(),
                                                  device_->capabilities().compute_family);
  }

  std::unique_ptr<vulkan::OwnDevice> device_;
  std::unique_ptr<vulkan::Context> context_;
  std::unique_ptr<osd::VkDeviceContext> device_context_;
};

}  // namespace planish::testing
