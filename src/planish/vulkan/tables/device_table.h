#pragma once

#include <cstdint>
#include <vector>

#include "planish/stencil/stencil_table.h"
#include "planish/vulkan/device/buffer.h"
#include "planish/vulkan/tables/table_slices.h"
#include "shaders/shared.h"

namespace planish::vulkan {

struct DeviceTableOptions {
  bool includes_own_rows = false;    ///< for square tables that solves use
  bool has_derivatives = false;      ///< packs the derivative weights as well
  std::uint64_t source_stride = 16;  ///< bytes from one point of the source to the next
  std::uint64_t target_stride = 16;  ///< bytes that a row takes in the target
};

/// A stencil table on the device, cut into slices. Read-only after its upload ran.
class DeviceTable {
 public:
  struct Slice {
    TableSlice rows;
    std::uint32_t first_group = 0, group_count = 0;
    Buffer entries, chunks, derivatives;
  };

  /// Plans the slices and takes the memory. Throws Error{OutOfMemory} naming the limit.
  template <class Real>
  DeviceTable(const Maker& on, const StencilView<Real>& table, const DeviceTableOptions& options);

  [[nodiscard]] const std::vector<Slice>& slices() const { return slices_; }
  [[nodiscard]] bool has_derivatives() const { return has_derivatives_; }
  [[nodiscard]] std::int32_t row_count() const { return row_count_; }
  [[nodiscard]] std::int32_t source_count() const { return source_count_; }
  [[nodiscard]] std::uint32_t group_total() const { return group_total_; }
  /// Partial sums that an interpolation step over all slices yields.
  [[nodiscard]] std::uint32_t partials_total() const;

  /// What is to be copied into slice `i`'s buffers. The view is that given on construction.
  template <class Real>
  [[nodiscard]] PackedSlice pack(std::size_t i, const StencilView<Real>& table) const;

  /// Where each row went: lane i of chunk c is slot c * shared::kChunkRows + i, chunks counted
  /// through all slices.
  [[nodiscard]] std::vector<std::uint32_t> slots() const;

  /// Drops what only pack() needs.
  void finish_packing() { plan_ = {}; }

  /// Parameters of a dispatch over slice `i` whose target window begins with the slice's rows.
  [[nodiscard]] shared::TableParameters parameters(std::size_t i) const noexcept;

  /// Binds pipeline and set and dispatches the slice's work groups for each instance.
  void record_dispatch(VkCommandBuffer commands, Kernel kernel, VkDescriptorSet set, std::size_t i,
                       const shared::TableParameters& parameters,
                       std::uint32_t instances = 1) const noexcept;

 private:
  Context& context_;
  TablePlan plan_;
  std::vector<Slice> slices_;
  std::int32_t row_count_, source_count_;
  bool has_derivatives_;
  std::uint32_t group_total_ = 0;
};

/// Work groups of 64 that do a row a lane.
[[nodiscard]] constexpr std::uint32_t row_groups(std::uint64_t rows) {
  return static_cast<std::uint32_t>((rows + shared::kChunkRows - 1) / shared::kChunkRows);
}

/// The bytes of points [first, first + count) in a buffer of shared::kPointFloats floats each.
[[nodiscard]] BufferRange point_range(const Buffer& points, std::int32_t first, std::int32_t count);

}  // namespace planish::vulkan
