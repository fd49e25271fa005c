#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <memory>
#include <span>

#include "bench/options.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/embed.h"

namespace planish::bench {

/// Splits of the surface that a frame's vertices are made at.
inline constexpr int kFrameLevel = 2;
inline constexpr std::uint32_t kFrameVertexBytes = 24;

/// The best Vulkan device, seen by DeviceTrace. Null where there is none; throws Error{NoDevice}
/// where it does not start.
[[nodiscard]] std::unique_ptr<vulkan::VulkanMachine> traced_machine(const Options& options);

/// Everything that a host has for one instance, on a machine that outlives it; tables are there
/// and points are those of `mesh`.
struct DeviceFrame {
  DeviceFrame(vulkan::VulkanMachine& machine, const PolygonMesh& mesh,
              const vulkan::SystemOptions& options);

  /// Another solve of the same tables into the same vertices, of each slot's points in `given`.
  [[nodiscard]] vulkan::Solve make_solve(vulkan::VulkanMachine& machine,
                                         std::initializer_list<VkBuffer> given) const;
  void set_points(vulkan::VulkanMachine& machine, std::span<const glm::vec3> pose) const;

  vulkan::System system;
  vulkan::DeviceSystem tables;
  vulkan::Buffer points, vertices;
  vulkan::Solve solve;
};

}  // namespace planish::bench
