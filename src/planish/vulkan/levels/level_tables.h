#pragma once

#include <cstdint>
#include <deque>
#include <span>

#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/levels/level_records.h"

namespace planish::vulkan {

/// The surface at one level on a device; its links are those of the System's own level.
struct LevelTables {
  int level;
  PatchTables patches;
  std::uint32_t vertex_count, first_index, index_count;
  float chord;  ///< LevelRecords::chord
};

/// A LevelSet on a device, likewise.
struct LevelSetTables {
  /// `records` are of its levels. Throws Error{OutOfMemory} naming the limit that a table exceeds.
  LevelSetTables(const Maker& on, const LevelSet& set, std::span<const PatchRecords> records);

  std::deque<LevelTables> levels;
  Buffer indices;

  template <class Take>
  void for_each(const LevelSet& set, std::span<const PatchRecords> records,
                const Take& take) const {
    for (std::size_t i = 0; i < records.size(); ++i) levels[i].patches.for_each(records[i], take);
    take(indices, std::as_bytes(std::span(set.triangles)));
  }
};

}  // namespace planish::vulkan
