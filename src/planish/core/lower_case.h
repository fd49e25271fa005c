#pragma once

#include <string>
#include <string_view>

namespace planish {

/// Letters of ASCII in lower case, whatever a host's locale says; all other bytes as they are.
[[nodiscard]] constexpr char lower_case(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

[[nodiscard]] inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = lower_case(c);
  return lower;
}

}  // namespace planish
