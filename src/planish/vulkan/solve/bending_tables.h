#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>

#include "planish/core/raw_vector.h"
#include "planish/fair/least_bending.h"
#include "planish/mesh/placement.h"
#include "planish/vulkan/device/buffer.h"
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

}  // namespace planish::vulkan
