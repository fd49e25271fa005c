#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/vec3.hpp>
#include <list>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/embed.h"
#include "vulkan/host_commands.h"

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

/// Of a mesh's vertices, as a device is given them.
[[nodiscard]] inline std::vector<glm::vec3> points_of(const PolygonMesh& mesh) {
  return {mesh.positions.begin(), mesh.positions.end()};
}

/// Into mapped memory at an offset, for the device to see.
template <class Items>
void put(vulkan::Buffer& to, const Items& items, std::uint64_t offset = 0) {
  const auto bytes = std::as_bytes(std::span(items));
  std::memcpy(to.mapped().data() + offset, bytes.data(), bytes.size());
  to.flush();
}

/// A mapped buffer with these items.
template <class Items>
[[nodiscard]] vulkan::Buffer filled(vulkan::Context& context, const Items& items) {
  vulkan::Buffer buffer(context, std::span(items).size_bytes(), vulkan::MemoryUse::Upload);
  put(buffer, items);
  return buffer;
}

/// What the device wrote into mapped memory.
template <class Item>
[[nodiscard]] std::vector<Item> fetched(vulkan::Buffer& from, std::size_t count,
                                        std::uint64_t offset = 0) {
  from.invalidate();
  std::vector<Item> items(count);
  std::memcpy(items.data(), from.mapped().data() + offset, count * sizeof(Item));
  return items;
}

/// The tables' bytes, by staging memory of their own.
void upload_tables(vulkan::Context& context, vulkan::Submitter& submitter,
                   const vulkan::System& system, const vulkan::DeviceSystem& tables);

/// What a host keeps for one topology: tables that are on the device, and an index buffer.
struct HostTopology {
  HostTopology(vulkan::Context& context, vulkan::Submitter& submitter, const PolygonMesh& rest,
               const vulkan::SystemOptions& options = {},
               const vulkan::DeviceSystemOptions& tables = {});

  vulkan::System system;
  vulkan::DeviceSystem device;
  vulkan::Buffer indices, staging;  // mapped
};

/// What a host keeps for one frame in flight of one instance or of several; its buffers are mapped.
struct HostFrame {
  HostFrame(vulkan::Context& context, const HostTopology& topology, const Layout& layout = {},
            std::uint32_t instances = 1, std::uint32_t max_iterations = 64);

  void set_points(const PolygonMesh& pose, std::uint32_t instance = 0);
  [[nodiscard]] std::vector<Vertex> vertices(std::uint32_t instance = 0);
  [[nodiscard]] vulkan::GpuStatus status(std::uint32_t instance = 0);
  /// Of an edit, where record_reach() wrote to reach_offset() of the report.
  [[nodiscard]] vulkan::EditReach reach();
  [[nodiscard]] std::uint64_t reach_offset() const;
  /// Of vertices, from an instance to the next.
  [[nodiscard]] std::uint64_t instance_stride() const;
  /// Solve, evaluation and status in one command buffer.
  void record(VkCommandBuffer commands, const vulkan::SolveParameters& parameters) const;

  std::int32_t vertex_count;
  std::uint32_t instances;
  Layout layout;
  vulkan::Buffer points, output, report;
  vulkan::Solve solve;
};

/// One Solve for all frames in flight, of a host that waits for a frame only where it wants its
/// slot back. Slots differ in layout; their frames' own Solves are not used.
class FramesInFlight {
 public:
  struct Slot {
    Slot(vulkan::Context& context, const vulkan::OwnDevice& device, const HostTopology& topology,
         const Layout& layout, std::uint32_t instances, std::uint32_t most_moves);
    HostFrame frame;
    vulkan::Buffer moves;  ///< the list of what edits move
    HostCommands commands;
    bool is_under_way = false;
  };

  /// With edits where `most_moves` are not 0.
  FramesInFlight(vulkan::Context& context, const vulkan::OwnDevice& device,
                 const HostTopology& topology, int count, std::uint32_t instances = 1,
                 std::uint32_t most_moves = 0);
  ~FramesInFlight();
  FramesInFlight(const FramesInFlight&) = delete;
  FramesInFlight& operator=(const FramesInFlight&) = delete;

  /// That frame's, where its slot was not given away since; waits for what was submitted with it.
  Slot& done(int number);
  /// Frames before it may still run.
  void submit(int number, const std::function<void(VkCommandBuffer, Slot&)>& record);
  [[nodiscard]] const vulkan::Solve& solve() const { return *solve_; }

 private:
  std::list<Slot> slots_;
  std::optional<vulkan::Solve> solve_;
};

/// A host's allocator of mapped memory, which counts.
class HostBlocks {
 public:
  HostBlocks(const vulkan::HostDevice& host, const VkPhysicalDeviceMemoryProperties& memory);

  [[nodiscard]] vulkan::MemoryHooks hooks();
  vulkan::MemoryBlock allocate(const vulkan::MemoryRequest& request);
  void free(const vulkan::MemoryBlock& block);

  std::map<vulkan::MemoryUse, int> taken;
  int living = 0, made = 0;

 private:
  VkDevice device_;
  VkPhysicalDeviceMemoryProperties memory_;
  vulkan::DeviceFunctions vk_;
};

}  // namespace planish::testing
