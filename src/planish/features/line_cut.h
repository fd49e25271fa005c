#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace planish {

/// A place that is either smooth or sharp, with what each costs.
struct LabelCost {
  double smooth = 0, sharp = 0;
};

/// Two places that should be alike: `cost` where they are not.
struct LabelLink {
  std::int32_t a, b;
  double cost;
};

/// One flag a place, 1: sharp. The labels that cost least in all, of several such those with the
/// fewest sharp places: a minimum cut (Dinic, 1970) of what is not decided by its own costs.
[[nodiscard]] std::vector<char> cheapest_labels(std::span<const LabelCost> costs,
                                                std::span<const LabelLink> links);

}  // namespace planish
