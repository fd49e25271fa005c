#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "planish/solve/stencil_table.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/driver.h"
#include "shaders/shared.h"

namespace planish::vulkan {

/// A point in a buffer.
inline constexpr std::uint64_t kPointBytes = shared::kPointFloats * sizeof(float);

/// Rows that are sorted by size together, so that rows of one chunk have about the same; slices
/// consist of whole windows. Where the limits are too low for that, windows are smaller.
inline constexpr std::int32_t kSortWindow = 1024;

/// Consecutive rows of a table that one dispatch does, with what its bindings must span.
struct TableSlice {
  std::size_t first_chunk = 0, chunk_count = 0;
  std::uint64_t entry_count = 0;  ///< padding included
  std::int32_t first_row = 0, row_count = 0;
  std::int32_t first_source = 0, source_count = 0;  ///< first_source is a multiple of 64
};

/// Where every row of a table goes; see shaders/shared.h for chunks.
struct TablePlan {
  std::vector<std::int32_t> row_of_slot;   ///< -1 in slots without a row
  std::vector<std::int32_t> chunk_widths;  ///< entries of the longest row, per chunk
  std::vector<TableSlice> slices;
};

struct SliceLimits {
  BindingLimit range;
  std::uint64_t max_chunks = 0;      ///< that one dispatch may walk
  std::uint64_t source_stride = 16;  ///< bytes from one point of the source to the next
  std::uint64_t target_stride = 16;  ///< bytes that a row takes in the target
  bool includes_own_rows = false;    ///< row i also reads source i
};

/// Cuts a table into as few slices as the limits allow. Throws Error{OutOfMemory} naming the limit
/// where the rows of one chunk alone exceed it.
template <class Real>
[[nodiscard]] TablePlan plan_table(const StencilView<Real>& table, const SliceLimits& limits);

struct PackedEntry {
  std::uint32_t source;  ///< counted from the slice's first_source
  float weight;
};

/// A slice as the kernels read it.
struct PackedSlice {
  std::vector<std::uint32_t> chunks;
  std::vector<PackedEntry> entries;
};

template <class Real>
[[nodiscard]] PackedSlice pack_slice(const StencilView<Real>& table, const TablePlan& plan,
                                     const TableSlice& slice);

/// Instances of one mesh whose vectors stand one after another in a buffer, so that one dispatch
/// does all of them, each as its work groups of one y.
struct Instances {
  std::uint32_t count = 1;

  /// Points from an instance's vector of `points` to the next one's: a binding may begin there.
  [[nodiscard]] std::uint64_t stride(std::uint64_t points) const {
    constexpr std::uint64_t kAligned = kBindingAlignment / kPointBytes;
    return count == 1 ? points : (points + kAligned - 1) / kAligned * kAligned;
  }
  [[nodiscard]] std::uint64_t bytes(std::uint64_t points) const {
    return count * stride(points) * kPointBytes;
  }
  /// Bytes from what the first instance has of a binding to what the last one has.
  [[nodiscard]] std::uint64_t last_offset(std::uint64_t points) const {
    return (count - 1) * stride(points) * kPointBytes;
  }
  /// A binding of a part of each instance's vector of `points`, given that of the first one.
  [[nodiscard]] BufferRange widened(BufferRange first, std::uint64_t points) const {
    first.size += last_offset(points);
    return first;
  }
  [[nodiscard]] std::uint32_t further() const { return count - 1; }
};

/// Instances that a kernel lists for dispatches to come: work group y does the instance that word
/// `first + y` of the buffer names.
struct InstanceList {
  const Buffer* words = nullptr;  ///< null: all instances are done
  std::uint32_t first = shared::kNone;
};

struct DeviceTableOptions {
  bool includes_own_rows = false;    ///< for square tables that solves use
  std::uint64_t source_stride = 16;  ///< bytes from one point of the source to the next
  std::uint64_t target_stride = 16;  ///< bytes that a row takes in the target
};

/// A stencil table on the device, cut into slices. Read-only after its upload ran.
class DeviceTable {
 public:
  struct Slice {
    TableSlice rows;
    std::uint32_t first_group = 0, group_count = 0;
    Buffer entries, chunks;
  };

  /// Plans the slices and takes the memory. Throws Error{OutOfMemory} naming the limit.
  template <class Real>
  DeviceTable(const Maker& on, const StencilView<Real>& table, const DeviceTableOptions& options);

  [[nodiscard]] const std::vector<Slice>& slices() const { return slices_; }
  [[nodiscard]] std::int32_t row_count() const { return row_count_; }
  [[nodiscard]] std::int32_t source_count() const { return source_count_; }
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
  std::uint32_t group_total_ = 0;
};

/// Work groups of 64 that do a row a lane.
[[nodiscard]] constexpr std::uint32_t row_groups(std::uint64_t rows) {
  return static_cast<std::uint32_t>((rows + shared::kChunkRows - 1) / shared::kChunkRows);
}

/// The bytes of points [first, first + count) in a buffer of shared::kPointFloats floats each.
[[nodiscard]] BufferRange point_range(const Buffer& points, std::int32_t first, std::int32_t count);

/// Elements of `length` floats in a buffer, `stride` floats apart, the first one at `offset`
/// floats.
struct FloatElements {
  VkBuffer buffer = VK_NULL_HANDLE;
  std::uint64_t offset = 0;
  std::uint32_t length = 0, stride = 0;
};

/// Rows [begin, end) of a table.
struct PassRows {
  std::int32_t begin = 0, end = 0;
};

/// The window that a binding of elements [first, first + count) spans, begun where every device
/// lets a binding begin.
struct ElementWindow {
  BufferRange range;
  std::uint32_t shift = 0;  ///< floats from the window's start to element `first`
};
[[nodiscard]] ElementWindow element_window(const FloatElements& elements, std::uint64_t first,
                                           std::uint64_t count);

/// Elements `stride` floats apart that one dispatch does, a lane each: a multiple of `unit`, as
/// many as one binding spans wherever they begin, and as work groups of 64 may be.
[[nodiscard]] std::uint64_t elements_at_once(const Context& context, std::uint64_t stride,
                                             std::uint64_t unit);

/// Throws Error{OutOfMemory}, naming the limit, where no binding can span the window; see
/// BindingLimit::require().
void require_window(const Context& context, const ElementWindow& window, const std::string& what,
                    const std::string& remedy = "use smaller strides");

/// Element i of the target = row i of the table applied to the source, for a range of rows. Source
/// and target may lie in one buffer where their floats are not the same ones. The table outlives
/// it, and so do the buffers.
class StencilPass {
 public:
  /// What kernels need, compiled now rather than by the first pass.
  static void compile(const Context& context, std::uint32_t length, std::uint32_t source_stride,
                      std::uint32_t target_stride);

  /// Both sides have the same length. Throws Error{OutOfMemory} naming the limit that the sources
  /// of the table's rows exceed.
  StencilPass(Context& context, const DeviceTable& table, const FloatElements& source,
              const FloatElements& target, const PassRows& rows);

  /// Only records, within kEntryScope and kExitScope.
  void record(VkCommandBuffer commands) const noexcept;

 private:
  struct Dispatch {
    shared::StencilParameters parameters;
    std::uint32_t groups;
  };

  Context& context_;
  Pipeline pipeline_;
  std::vector<Dispatch> dispatches_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
