#pragma once

#include <memory>

#include "planish/osd/vk_device_context.h"
#include "planish/osd/vk_vertex_buffer.h"
#include "planish/vulkan/device/own_device.h"
#include "vulkan/fixture.h"

namespace planish::testing {

/// A device with validation and synchronization validation, and what OpenSubdiv's classes need.
class OsdTest : public VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    make_device();
  }

  void TearDown() override {
    close();
    VulkanTest::TearDown();
  }

  /// By the loader's own function, or by one that pretends.
  void make_device(PFN_vkGetInstanceProcAddr get_proc = nullptr) {
    close();
    device_ = std::make_unique<vulkan::OwnDevice>(device_options(get_proc));
    make_context({});
  }

  void close() {
    device_context_.reset();
    context_.reset();
    device_.reset();
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

  std::unique_ptr<osd::VkVertexBuffer> buffer_of(const std::vector<float>& floats) {
    const int count = static_cast<int>(floats.size());
    std::unique_ptr<osd::VkVertexBuffer> buffer(
        osd::VkVertexBuffer::Create(1, count, device_context_.get()));
    buffer->UpdateData(floats.data(), 0, count, device_context_.get());
    return buffer;
  }

  std::vector<float> floats_of(const osd::VkVertexBuffer& buffer) {
    std::vector<float> floats(std::size_t(buffer.GetNumVertices()) * buffer.GetNumElements());
    buffer.ReadData(floats.data(), 0, buffer.GetNumVertices(), device_context_.get());
    return floats;
  }

  std::unique_ptr<vulkan::OwnDevice> device_;
  std::unique_ptr<vulkan::Context> context_;
  std::unique_ptr<osd::VkDeviceContext> device_context_;
};

}  // namespace planish::testing
