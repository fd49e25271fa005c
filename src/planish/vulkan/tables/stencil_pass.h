#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planish/vulkan/device/buffer.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {

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
