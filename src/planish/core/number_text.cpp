#include "planish/core/number_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

#include "planish/core/lower_case.h"

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

namespace {

// Powers of ten that doubles hold exactly.
constexpr std::array<double, 23> kPowersOfTen = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                 1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

// Digits with at most one point and a minus before them, where number and power of ten are exact
// doubles: their quotient is then rounded once, as it has to be. Based on: Clinger, "How to read
// floating point numbers accurately", 1990.
bool parse_plain(std::string_view token, double& value) {
  constexpr std::size_t kMostDigits = 16;  // more are above 2^53, but for zeros before them
  constexpr std::uint64_t kLargestExact = std::uint64_t{1} << 53;
  const char* at = token.data();
  const char* const end = at + token.size();
  const bool negative = at < end && *at == '-';
  at += negative ? 1 : 0;
  if (static_cast<std::size_t>(end - at) > kMostDigits + 1) return false;
  std::uint64_t digits = 0;
  const char* point = nullptr;
  std::ptrdiff_t count = 0;
  for (; at < end; ++at) {
    const auto digit = static_cast<unsigned char>(*at - '0');
    if (digit <= 9) {
      digits = 10 * digits + digit;
      ++count;
    } else if (*at == '.' && point == nullptr) {
      point = at;
    } else {
      return false;
    }
  }
  if (count == 0 || count > static_cast<std::ptrdiff_t>(kMostDigits) || digits > kLargestExact)
    return false;
  const std::ptrdiff_t decimals = point == nullptr ? 0 : end - point - 1;
  const double magnitude = static_cast<double>(digits) / kPowersOfTen[decimals];
  value = negative ? -magnitude : magnitude;
  return true;
}

}  // namespace

bool parse_number(std::string_view token, double& value) {
  token = without_plus(token);
  if (parse_plain(token, value)) return true;
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

namespace {

// Without its sign, in lower case.
std::string plain_word(std::string_view word) {
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  return lower_case(word.substr(0, 16));
}

}  // namespace

bool is_nan_word(std::string_view word) {
  const std::string plain = plain_word(word);
  return plain == "nan" || (plain.starts_with("nan(") && plain.ends_with(')')) ||
         plain.starts_with("1.#ind") || plain.starts_with("1.#qnan") ||
         plain.starts_with("1.#snan");
}

bool is_non_finite_word(std::string_view word) {
  const std::string plain = plain_word(word);
  return plain == "inf" || plain == "infinity" || plain.starts_with("1.#inf") || is_nan_word(word);
}

std::string no_finite_number(std::string_view word) {
  const std::string what = quote(word) + " is no finite number";
  std::string meant(word);
  const std::size_t comma = word.find(','), sign = word.find_first_of("+-", 1);
  if (comma != std::string_view::npos) {
    meant[comma] = '.';
  } else if (sign != std::string_view::npos) {
    // Programs that read 3.1+e2 take it for 3.1 or for 310.
    if (meant.substr(sign + 1, 1) != "e" && meant.substr(sign + 1, 1) != "E") return what;
    std::swap(meant[sign], meant[sign + 1]);
  }
  double value = 0;
  return parse_number(meant, value) ? what + "; write " + meant + " if that is meant" : what;
}

std::string shortest(double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end.ptr};
}

std::string short_number(double number) {
  std::array<char, 32> digits;
  const double magnitude = std::abs(number);
  const bool is_whole = magnitude >= 999.5 && magnitude < 1e6;
  std::snprintf(digits.data(), digits.size(), is_whole ? "%.0f" : "%.3g", number);
  return digits.data();
}

std::string percent(double share) {
  constexpr double kLeast = 1e-5, kMost = 0.9995;
  if (share > 0 && share < kLeast) return "under 0.001 %";
  if (share >= kMost && share < 1) return "over 99.9 %";
  return short_number(100 * share) + " %";
}

std::string fixed(double number, int decimals) {
  std::array<char, 400> buffer{};  // the largest double has 309 digits before the point
  std::snprintf(buffer.data(), buffer.size(), "%.*f", decimals, number);
  return buffer.data();
}

std::string byte_size(std::uint64_t bytes) {
  if (bytes < 1024) return std::to_string(bytes) + " B";
  double size = static_cast<double>(bytes);
  const char* unit = "";
  for (const char* next : {"KiB", "MiB", "GiB", "TiB"}) {
    if (size < 1024) break;
    size /= 1024;
    unit = next;
  }
  std::array<char, 32> digits;
  std::snprintf(digits.data(), digits.size(), "%.1f ", size);
  return digits.data() + std::string(unit);
}

}  // namespace planish
