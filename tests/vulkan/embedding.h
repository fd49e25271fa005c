#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/embed.h"

namespace planish::testing {

struct Vertex {
  glm::vec3 position, normal;
};

/// The mesh with its vertices moved smoothly, differently in each frame.
[[nodiscard]] PolygonMesh posed(const PolygonMesh& rest, int frame);

/// The same mesh, all of whose faces are seen.
[[nodiscard]] PolygonMesh without_holes(PolygonMesh mesh);

/// The vertices of the interpolating surface, those that only holes name included, by fit() and
/// evaluate() in double on the CPU, in the order of a System's. Corners have the angles of `rest`.
[[nodiscard]] std::vector<Vertex> surface_by_cpu(const PolygonMesh& mesh, const PolygonMesh& rest,
                                                 const vulkan::SystemOptions& options);

/// The largest distance of positions, and the smallest cosine between normals (1 where both are
/// zero or the CPU's stands in for one without direction).
struct Difference {
  double distance = 0, cosine = 1;
};
[[nodiscard]] Difference difference(const std::vector<Vertex>& a, const std::vector<Vertex>& b);

[[nodiscard]] inline bool same_bits(const std::vector<Vertex>& a, const std::vector<Vertex>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

/// Where a host wants its vertices.
struct Layout {
  std::uint32_t offset = 0, stride = 24, position_offset = 0, normal_offset = 12;
  std::uint32_t gap = 0;  ///< bytes between instances
};

/// Of a status, to compare: all of its 12 bytes.
[[nodiscard]] inline std::array<std::uint32_t, 3> bits_of(const vulkan::GpuStatus& status) {
  return std::bit_cast<std::array<std::uint32_t, 3>>(status);
}

/// What a host keeps for one topology: tables, and an index buffer.
struct HostTopology {
  HostTopology(vulkan::Context& context, const PolygonMesh& rest,
               const vulkan::SystemOptions& options = {}, std::uint32_t max_vertex_stride = 64);
  /// From its staging memory to the device.
  void upload(vulkan::Submitter& submitter);

  vulkan::System system;
  vulkan::DeviceSystem device;
  vulkan::Buffer indices, staging;  // mapped
};

/// What a host keeps for one frame in flight of one instance or of several; its buffers are mapped.
struct HostFrame {
  HostFrame(vulkan::Context& context, const HostTopology& topology, const Layout& layout = {},
            std::uint32_t max_iterations = 64, std::uint32_t instances = 1);

  void set_points(const PolygonMesh& pose, std::uint32_t instance = 0);
  [[nodiscard]] std::vector<Vertex> vertices(std::uint32_t instance = 0);
  [[nodiscard]] vulkan::GpuStatus status(std::uint32_t instance = 0);
  /// Of vertices, from an instance to the next.
  [[nodiscard]] std::uint64_t instance_stride() const;
  /// Solve, evaluation and status in one command buffer.
  void record(VkCommandBuffer commands, const vulkan::SolveParameters& parameters) const;

  std::int32_t vertex_count;
  Layout layout;
  vulkan::Buffer points, output, report;
  vulkan::Solve solve;
};

/// A command buffer that a host records once and submits as often as it likes, with a fence. Made
/// of functions that the host loads for itself.
class HostCommands {
 public:
  HostCommands(const vulkan::OwnDevice& device,
               VkCommandBufferLevel level = VK_COMMAND_BUFFER_LEVEL_PRIMARY);
  ~HostCommands();
  HostCommands(const HostCommands&) = delete;
  HostCommands& operator=(const HostCommands&) = delete;

  void record(const std::function<void(VkCommandBuffer)>& work);
  void submit();
  void wait();
  [[nodiscard]] VkCommandBuffer handle() const { return commands_; }
  [[nodiscard]] const vulkan::DeviceFunctions& vk() const { return vk_; }

 private:
  vulkan::HostDevice host_;
  vulkan::DeviceFunctions vk_;
  VkQueue queue_;
  VkCommandBufferLevel level_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
};

}  // namespace planish::testing
