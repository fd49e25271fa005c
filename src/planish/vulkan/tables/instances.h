#pragma once

#include <cstdint>

#include "planish/vulkan/device/buffer.h"
#include "planish/vulkan/tables/table_slices.h"

namespace planish::vulkan {

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

}  // namespace planish::vulkan
