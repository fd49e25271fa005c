#include "planish/vulkan/solve/bending_tables.h"

#include <bit>

#include "planish/core/parallel.h"

namespace planish::vulkan {

BendingRecords bending_records(const BendingTable& table, double unit, double bound) {
  BendingRecords records;
  records.unit = unit;
  records.bound = bound;
  records.vertices.resize(static_cast<std::size_t>(table.vertex_count()));
  parallel_each(records.vertices.size(), [&](std::int32_t v) {
    const auto count = static_cast<std::uint32_t>(table.row(v).size());
    records.vertices[v] = {static_cast<std::uint32_t>(table.offsets[v]),
                           table.kinds[v] | (table.is_closed[v] != 0 ? shared::kBendingClosed : 0) |
                               count << shared::kBendingCountShift,
                           table.inverse_areas[v], table.steps[v]};
  });
  records.entries.resize(table.entries.size());
  records.theirs.resize(table.entries.size());
  parallel_each(records.entries.size(), [&](std::size_t i) {
    const BendingTable::Entry& entry = table.entries[i];
    records.entries[i] = {static_cast<std::uint32_t>(entry.vertex),
                          std::bit_cast<std::uint32_t>(entry.own)};
    records.theirs[i] = entry.theirs;
  });
  return records;
}

BendingTables::BendingTables(const Maker& on, const BendingRecords& records)
    : vertex_count(static_cast<std::uint32_t>(records.vertices.size())),
      unit(static_cast<float>(records.unit)),
      bound(static_cast<float>(records.bound)),
      vertices(make_bindable(on, std::as_bytes(std::span(records.vertices)).size(),
                             "planish bending vertices")),
      entries(make_bindable(on, std::as_bytes(std::span(records.entries)).size(),
                            "planish bending entries")),
      theirs(make_bindable(on, std::as_bytes(std::span(records.theirs)).size(),
                           "planish bending weights")) {}

}  // namespace planish::vulkan
