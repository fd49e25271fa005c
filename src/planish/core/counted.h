#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace planish {

/// "vertex" of one, "vertices" of all other counts.
[[nodiscard]] inline std::string noun_for(std::int64_t count, std::string_view singular) {
  std::string noun(singular);
  if (count == 1) return noun;
  if (noun.ends_with("ex")) return noun.replace(noun.size() - 2, 2, "ices");
  return noun + (noun.ends_with("sh") ? "es" : "s");
}

/// 1234567 -> "1,234,567".
[[nodiscard]] inline std::string with_separators(std::int64_t number) {
  std::string digits = std::to_string(number);
  const std::size_t first = number < 0 ? 1 : 0;
  for (std::size_t place = digits.size(); place > first + 3;) {
    place -= 3;
    digits.insert(place, 1, ',');
  }
  return digits;
}

/// "1 face", "2,000 faces"; "1 vertex", "2 vertices".
[[nodiscard]] inline std::string counted(std::int64_t count, std::string_view singular) {
  return with_separators(count) + " " + noun_for(count, singular);
}

}  // namespace planish
