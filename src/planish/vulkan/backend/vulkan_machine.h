#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planish/backend/backend.h"
#include "planish/vulkan/device/own_device.h"
#include "planish/vulkan/device/submitter.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {

/// The command's device with all that works on it. Shared by a backend and what it hands out.
struct VulkanMachine {
  VulkanMachine(const OwnDeviceOptions& device_options, const ContextOptions& context_options)
      : device(device_options),
        context(device, context_options),
        submitter(context, device.queue(), device.capabilities().compute_family) {}

  OwnDevice device;
  Context context;
  Submitter submitter;

  /// Packs and uploads all slices of a new table.
  void upload_table(DeviceTable& table, const StencilView<double>& view);
  /// Points as shared::kPointFloats floats, rounded to nearest.
  void upload_points(const Buffer& target, std::span<const glm::dvec3> points);
  [[nodiscard]] std::vector<glm::dvec3> download_points(const Buffer& source, std::size_t count);
};

/// The backend on it.
[[nodiscard]] std::unique_ptr<Backend> make_backend(std::shared_ptr<VulkanMachine> machine);

}  // namespace planish::vulkan
