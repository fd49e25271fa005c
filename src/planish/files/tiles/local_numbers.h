#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "planish/core/raw_vector.h"

namespace planish {

/// Replaces numbers (of rows, not negative) by their places among those that occur, which it
/// returns in ascending order.
[[nodiscard]] inline RawVector<std::int32_t> make_local(std::span<std::int32_t> numbers) {
  // Open addressing: a number and its place in the order of first use, at most half full.
  struct Entry {
    std::int32_t number = -1, place = 0;
  };
  std::vector<Entry> table(1024);
  RawVector<std::int32_t> found;
  const auto entry_of = [&](std::int32_t number) -> Entry& {
    const std::size_t mask = table.size() - 1;
    // Rows come in runs, which keep their order here for a cache line or so; where runs lie is
    // mixed, for they begin at multiples of each other's lengths.
    constexpr int kRunBits = 6;
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ull;  // 2^64 over the golden ratio
    const auto given = static_cast<std::uint32_t>(number);
    const std::uint64_t run = (given >> kRunBits) * kGolden >> 32;
    std::size_t at = (run << kRunBits | (given & ((1u << kRunBits) - 1))) & mask;
    while (table[at].number >= 0 && table[at].number != number) at = (at + 1) & mask;
    return table[at];
  };
  for (std::int32_t& number : numbers) {
    Entry* entry = &entry_of(number);
    if (entry->number < 0) {
      if (2 * (found.size() + 1) > table.size()) {
        table.assign(2 * table.size(), {});
        for (std::size_t i = 0; i < found.size(); ++i)
          entry_of(found[i]) = {found[i], static_cast<std::int32_t>(i)};
        entry = &entry_of(number);
      }
      *entry = {number, static_cast<std::int32_t>(found.size())};
      found.push_back(number);
    }
    number = entry->place;
  }
  std::vector<std::pair<std::int32_t, std::int32_t>> order(found.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    order[i] = {found[i], static_cast<std::int32_t>(i)};
  std::ranges::sort(order);
  RawVector<std::int32_t> place_of(found.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    found[i] = order[i].first;
    place_of[order[i].second] = static_cast<std::int32_t>(i);
  }
  for (std::int32_t& number : numbers) number = place_of[number];
  return found;
}

}  // namespace planish
