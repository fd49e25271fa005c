#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/fair/bending.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/solve/gpu_solve.h"
#include "planish/vulkan/tables/device_table.h"
#include "shaders/shared.h"

namespace planish::vulkan {

/// A BendingTable as the kernels read it, and how far points may move.
struct BendingRecords {
  RawVector<shared::BendingVertex> vertices;
  RawVector<glm::uvec2> entries;
  RawVector<float> theirs;
  double unit = 1;   ///< model units of one of the table's
  double bound = 0;  ///< model units
};
[[nodiscard]] BendingRecords bending_records(const BendingTable& table, double unit, double bound);

/// BendingRecords on a device. Read-only after its upload ran.
struct BendingTables {
  /// Throws Error{OutOfMemory} naming the limit that a table exceeds.
  BendingTables(const Maker& on, const BendingRecords& records);

  std::uint32_t vertex_count;
  float unit, bound;
  Buffer vertices, entries, theirs;

  /// Calls take(buffer, bytes) for all of them, in one order.
  template <class Take>
  void for_each(const BendingRecords& records, const Take& take) const {
    take(vertices, std::as_bytes(std::span(records.vertices)));
    take(entries, std::as_bytes(std::span(records.entries)));
    take(theirs, std::as_bytes(std::span(records.theirs)));
  }
};

/// least_bending_moves() in a command buffer, of gathered points that it moves in place. Externally
/// synchronised; tables and points outlive it. Recording only records.
class GpuLeastBending {
 public:
  /// `points`: shared::kPointFloats floats per vertex, of one instance after another.
  /// Throws Error{OutOfMemory} naming the limit.
  GpuLeastBending(const Maker& on, const BendingTables& tables, const Buffer& points,
                  const Instances& instances = {});

  static constexpr std::uint32_t kRoundCount = 1 + 2 * kLeastBendingSteps;
  Wait record_round(VkCommandBuffer commands, std::uint32_t round) const noexcept;

 private:
  Context& context_;
  Instances instances_;
  shared::BendingParameters parameters_;
  std::uint32_t groups_;
  std::array<double, kLeastBendingSteps> momenta_;
  std::array<Pipeline, 3> pipelines_;
  Buffer directions_, base_, rows_, moves_, ahead_;  // a point per vertex
  DescriptorSets sets_;                              // of the three kernels
};

/// The way from a host's points, whatever their layout, to one point for each used vertex.
class GpuGather {
 public:
  /// `vertices` holds the index of each row's point, which `row_vertices` has on the host; `given`
  /// has a host's points for each slot. Instances are given.instance_stride apart, which is not 0
  /// where there are several.
  GpuGather(const Maker& on, const Buffer& vertices, std::span<const std::int32_t> row_vertices,
            std::span<const GivenPoints> given, const Instances& instances = {});

  /// Of a slot's points. Within kEntryScope; a barrier from kKernelScope comes before the points
  /// are read.
  void record(VkCommandBuffer commands, std::uint32_t slot) const noexcept;

  /// shared::kPointFloats floats per row, instance by instance.
  [[nodiscard]] const Buffer& points() const { return points_; }

  /// A slot's points, as its binding has them.
  struct Source {
    BufferRange range;
    std::uint32_t shift;                    // floats between the range's start and point 0
    std::uint32_t stride, instance_floats;  // from a point to the next, from an instance
  };
  [[nodiscard]] const Source& source(std::uint32_t slot) const { return sources_[slot]; }

 private:
  [[nodiscard]] Source source_of(std::int32_t last_vertex, const GivenPoints& given) const;

  Context& context_;
  Instances instances_;
  std::uint64_t row_count_;
  std::vector<Source> sources_;
  Buffer points_;
  DescriptorSets sets_;
};

/// The way from a host's points to a solve's right-hand side and start, and from its displacement
/// to control points. Externally synchronised; solve and tables outlive it.
class GpuGiven {
 public:
  /// For the solve's instances. `vertices` holds the index of each row's point, which
  /// `row_vertices` has on the host; `given` has a host's points for each slot.
  GpuGiven(const Maker& on, const DeviceTable& masks, const GpuSolve& solve, const Buffer& vertices,
           std::span<const std::int32_t> row_vertices, std::span<const GivenPoints> given);

  /// Points of a slot, and the displacement from the last one or zero; within kEntryScope.
  Wait record_points(VkCommandBuffer commands, bool warm_start, std::uint32_t slot) const noexcept;
  /// Then the right-hand side from the points.
  Wait record_residual(VkCommandBuffer commands) const noexcept;
  /// control_points() = given() + displacement(). Within kEntryScope; kKernelWait comes after it.
  void record_control_points(VkCommandBuffer commands) const noexcept;

  // Of shared::kPointFloats floats per row, instance by instance.
  [[nodiscard]] const Buffer& given() const { return gather_.points(); }
  [[nodiscard]] const Buffer& displacement() const { return moved_; }
  [[nodiscard]] const Buffer& control_points() const { return control_; }
  [[nodiscard]] const GpuGather& gather() const { return gather_; }

 private:
  void bind(const Maker& on, const GpuSolve& solve);
  void record_rows(VkCommandBuffer commands, Kernel kernel, std::size_t set,
                   bool warm_start) const noexcept;

  Context& context_;
  const DeviceTable& masks_;
  Instances instances_;
  std::uint64_t row_count_;
  GpuGather gather_;
  Buffer control_, moved_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
