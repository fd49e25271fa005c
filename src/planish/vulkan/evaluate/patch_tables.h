#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/vulkan/device/buffer.h"
#include "planish/vulkan/evaluate/patch_records.h"
#include "planish/vulkan/evaluate/step_records.h"

namespace planish::vulkan {

/// What patches must keep to on a device. `row_stride`: bytes from one row of the output to the
/// next, at most.
[[nodiscard]] PatchLimits patch_limits(const Context& context, std::uint32_t row_stride);

/// PatchRecords on a device. Read-only after its upload ran.
struct PatchTables {
  /// Throws Error{OutOfMemory} naming the limit that a table exceeds.
  PatchTables(const Maker& on, const PatchRecords& records, std::int64_t point_count);

  std::int64_t point_count;  ///< of the state of level 1 and its sums
  std::uint32_t ring_count;
  bool has_frames;  ///< rows can have tangents
  std::int64_t first_sum;
  std::vector<PatchSlice> slices;
  Buffer links, groups, words, weights, rings;

  /// Calls take(buffer, bytes) for all of them, in one order.
  template <class Take>
  void for_each(const PatchRecords& records, const Take& take) const {
    const auto bytes = [](const auto& items) { return std::as_bytes(std::span(items)); };
    take(links, bytes(records.links));
    take(groups, bytes(records.groups));
    take(words, bytes(records.words));
    take(weights, bytes(records.weights));
    take(rings, bytes(records.rings));
  }
};

/// StepRecords on a device, likewise.
struct StepTables {
  StepTables(const Maker& on, const StepRecords& records);

  std::vector<StepPart> parts;
  FaceSumRule rule;
  Buffer vertices, words;

  template <class Take>
  void for_each(const StepRecords& records, const Take& take) const {
    const auto bytes = [](const auto& items) { return std::as_bytes(std::span(items)); };
    take(vertices, bytes(records.vertices));
    take(words, bytes(records.words));
  }
};

/// The part of a buffer of items that a window spans, at least one item: a binding may not be
/// empty.
[[nodiscard]] BufferRange window_range(const Buffer& items, const IndexWindow& window,
                                       std::uint64_t item_bytes);

}  // namespace planish::vulkan
