#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace planish {

/// The candidate that `word` is most likely a slip of: fewest inserted, deleted, replaced or
/// swapped letters, at most a third of its length (but 2 at least). Of equally near ones the first.
/// Else the shortest that `word` is the beginning of.
[[nodiscard]] std::optional<std::string_view> nearest(std::string_view word,
                                                      std::span<const std::string_view> candidates);

/// "; did you mean X?" or nothing.
[[nodiscard]] std::string did_you_mean(std::string_view word,
                                       std::span<const std::string_view> candidates);

}  // namespace planish
