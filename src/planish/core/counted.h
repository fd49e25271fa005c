#pragma once

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

/// "1 vertex", "2 vertices".
[[nodiscard]] inline std::string counted(std::int64_t count, std::string_view singular) {
  return std::to_string(count) + " " + noun_for(count, singular);
}

}  // namespace planish
