#pragma once

#include <cstdint>
#include <span>

#include "planish/vulkan/device/buffer.h"
#include "planish/vulkan/edit/edit_records.h"

namespace planish::vulkan {

/// EditRecords on a device. Read-only after its upload ran.
struct EditTables {
  /// Throws Error{OutOfMemory} naming the limit that a table exceeds.
  EditTables(const Maker& on, const EditRecords& records);

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

}  // namespace planish::vulkan
