#include "planish/vulkan/levels/level_tables.h"

namespace planish::vulkan {

LevelSetTables::LevelSetTables(const Maker& on, const LevelSet& set,
                               std::span<const PatchRecords> records)
    : indices(on, set.triangles.size() * sizeof(std::uint32_t), MemoryUse::Device,
              "planish indices") {
  for (std::size_t i = 0; i < records.size(); ++i) {
    const LevelRecords& level = set.levels[i];
    const std::int32_t points = level.patches.mesh().point_count();
    levels.push_back({level.patches.numbering().level(), PatchTables(on, records[i], points),
                      static_cast<std::uint32_t>(level.patches.numbering().row_count()),
                      static_cast<std::uint32_t>(level.first_index),
                      static_cast<std::uint32_t>(level.index_count),
                      static_cast<float>(level.chord)});
  }
}

}  // namespace planish::vulkan
