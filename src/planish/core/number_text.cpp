#include "planish/core/number_text.h"

#include <array>
#include <charconv>
#include <cmath>

namespace planish {
namespace {

// std::from_chars takes no plus sign.
std::string_view without_plus(std::string_view token) {
  const bool signed_twice = token.size() > 1 && token[1] == '-';
  if (token.starts_with('+') && !signed_twice) token.remove_prefix(1);
  return token;
}

}  // namespace

std::string quote(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string result = "`";
  for (const char c : text.substr(0, kLongest)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > kLongest ? "...`" : "`");
}

bool parse_number(std::string_view token, double& value) {
  token = without_plus(token);
  double parsed = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), parsed);
  if (error != std::errc() || end != token.data() + token.size() || !std::isfinite(parsed))
    return false;
  value = parsed;
  return true;
}

bool parse_integer(std::string_view token, std::int64_t& value) {
  token = without_plus(token);
  std::int64_t parsed = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), parsed);
  if (error != std::errc() || end != token.data() + token.size()) return false;
  value = parsed;
  return true;
}

std::string shortest(double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end.ptr};
}

}  // namespace planish
