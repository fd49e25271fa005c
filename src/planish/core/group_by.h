#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace planish {

/// Values by group, one group after another.
template <class Value>
struct Groups {
  std::vector<std::int32_t> offsets;  ///< one a group and the end
  std::vector<Value> values;

  [[nodiscard]] std::span<const Value> of(std::size_t group) const {
    return std::span(values).subspan(static_cast<std::size_t>(offsets[group]),
                                     static_cast<std::size_t>(offsets[group + 1] - offsets[group]));
  }
};

/// Counting sort: `visit(take)` is called twice and calls take(group, value) for the same values
/// both times; within a group they keep their order. There must be fewer than 2^31.
template <class Value, class Visit>
[[nodiscard]] Groups<Value> group_by(std::size_t group_count, const Visit& visit) {
  Groups<Value> groups;
  // Shifted by one group: where a group ends once its values stand.
  groups.offsets.assign(group_count + 2, 0);
  visit([&](std::size_t group, const Value&) { ++groups.offsets[group + 2]; });
  std::partial_sum(groups.offsets.begin(), groups.offsets.end(), groups.offsets.begin());
  groups.values.resize(static_cast<std::size_t>(groups.offsets.back()));
  visit([&](std::size_t group, const Value& value) {
    groups.values[groups.offsets[group + 1]++] = value;
  });
  groups.offsets.pop_back();
  return groups;
}

}  // namespace planish
