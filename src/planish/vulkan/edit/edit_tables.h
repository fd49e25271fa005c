#pragma once

#include <cstdint>
#include <span>

#include "planish/vulkan/device/buffer.h"
#include "planish/vulkan/edit/edit_records.h"

namespace planish::vulkan {

/// EditRecords on a device. Read-only after its upload ran.
struct EditTables {
  /// Throws Error{OutOfMemory} naming the limit that a table exceeds.
  EditTables(Context& context, const EditRecords& records);

  std::uint64_t job_count;
  Buffer slots, places, jobs;

  /// Calls take(buffer, bytes) for all of them, in one order.
  template <class Take>
  void for_each(const EditRecords& records, const Take& take) const {
    const auto bytes = [](const auto& items) { return std::as_bytes(std::span(items)); };
    take(slots, bytes(records.slots));
    take(places, bytes(records.places));
    take(jobs, bytes(records.jobs));
  }
};

/// Throws Error{OutOfMemory} where a device has no binding of so many bytes, read by texels of
/// `texel_bytes` (0: as words that kernels write), naming `what` and the limit.
void require_one_binding(const Context& context, std::uint64_t bytes, std::uint64_t texel_bytes,
                         const char* what);

}  // namespace planish::vulkan
