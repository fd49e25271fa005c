#include "planish/core/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/guards.h"
#include "planish/core/words.h"

namespace planish {
namespace {

// A code point of Unicode at the start of a text.
struct CodePoint {
  std::uint32_t value = 0;
  std::size_t length = 0;  // bytes; 0: no well-formed UTF-8 stands there
};

struct Range {
  std::uint32_t first, last;
};

constexpr std::array kInvisible{
    Range{0x0000, 0x001F},   Range{0x007F, 0x009F},   Range{0x00AD, 0x00AD},
    Range{0x034F, 0x034F},   Range{0x061C, 0x061C},   Range{0x115F, 0x1160},
    Range{0x17B4, 0x17B5},   Range{0x180B, 0x180F},   Range{0x200B, 0x200F},
    Range{0x2028, 0x202F},   Range{0x2060, 0x206F},   Range{0x3164, 0x3164},
    Range{0xE000, 0xF8FF},   Range{0xFDD0, 0xFDEF},   Range{0xFE00, 0xFE0F},
    Range{0xFEFF, 0xFEFF},   Range{0xFFA0, 0xFFA0},   Range{0xFFF0, 0xFFFB},
    Range{0xFFFE, 0xFFFF},   Range{0x1BCA0, 0x1BCA3}, Range{0x1D173, 0x1D17A},
    Range{0xE0000, 0x10FFFF}};

constexpr std::array kControls{Range{0x0000, 0x001F}, Range{0x007F, 0x009F}, Range{0x2028, 0x202E},
                               Range{0x2066, 0x2069}};

bool is_in(std::span<const Range> ranges, std::uint32_t code_point) {
  return std::ranges::any_of(ranges, [&](const Range& range) {
    return code_point >= range.first && code_point <= range.last;
  });
}

// That at the start of `text`, which is not empty.
CodePoint decode_utf8(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::uint32_t first = byte(0);
  if (first < 0x80) return {first, 1};
  if (first < 0xC2 || first > 0xF4) return {};
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (text.size() < length) return {};
  std::uint32_t point = first & (0x7Fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {};
    point = point << 6 | (byte(i) & 0x3Fu);
  }
  constexpr std::array<std::uint32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = point >= 0xD800 && point <= 0xDFFF;
  if (point < kLeast[length] || point > 0x10FFFF || is_surrogate) return {};
  return {point, length};
}

// What a reader cannot see, and what makes him see something else: Unicode's controls, format
// characters, line and paragraph separators, fillers, variation selectors and non-characters.
bool is_invisible(std::uint32_t code_point) { return is_in(kInvisible, code_point); }

// Of these, what ends a line for some reader or turns the direction of writing: controls, line
// and paragraph separators, embeddings, overrides and isolates. Joiners and marks, which names of
// many tongues need, are none.
bool is_control(std::uint32_t code_point) { return is_in(kControls, code_point); }

std::string escaped(const char* format, unsigned value) {
  std::array<char, 16> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

std::string escaped(std::uint32_t code_point) {
  if (code_point == '\n') return "\\n";
  if (code_point == '\r') return "\\r";
  if (code_point == '\t') return "\\t";
  return escaped(code_point < 0x80     ? "\\x%02x"
                 : code_point > 0xFFFF ? "\\u{%x}"
                                       : "\\u%04x",
                 code_point);
}

}  // namespace

std::string with_escapes(std::string_view text, std::string (*escape)(std::uint32_t)) {
  std::string out;
  while (!text.empty()) {
    const CodePoint point = decode_utf8(text);
    if (point.length == 0) {
      out += escaped("\\x%02x", static_cast<unsigned char>(text[0]));
    } else if (is_invisible(point.value)) {
      out += escape(point.value);
    } else {
      out += text.substr(0, point.length);
    }
    text.remove_prefix(std::max<std::size_t>(point.length, 1));
  }
  return out;
}

std::size_t utf8_length(std::string_view text) { return decode_utf8(text).length; }

std::string utf8(const std::filesystem::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}

std::filesystem::path path_of(std::string_view text) {
  return std::u8string_view(reinterpret_cast<const char8_t*>(text.data()), text.size());
}

std::string visible(std::string_view text) { return with_escapes(text, escaped); }
std::string in_double_quotes(std::string_view text) { return formatted("\"{}\"", visible(text)); }

std::string without_controls(std::string_view text, char other) {
  std::string out;
  while (!text.empty()) {
    const CodePoint point = decode_utf8(text);
    const std::size_t length = std::max<std::size_t>(point.length, 1);
    if (point.length > 0 && is_control(point.value)) {
      out += other;
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(length);
  }
  return out;
}

std::string visible_lines(std::string_view text) {
  return with_escapes(
      text, [](std::uint32_t point) { return point == '\n' ? std::string("\n") : escaped(point); });
}

void Formattable::append_to(std::string& text) const {
  if (!is_number_) {
    text += text_;
    return;
  }
  if (is_negative_) text += '-';
  std::array<char, 20> digits;
  text.append(digits.data(),
              std::to_chars(digits.data(), digits.data() + digits.size(), magnitude_).ptr);
}

std::string formatted_list(std::string_view format, std::initializer_list<Formattable> values) {
  std::string text;
  std::size_t from = 0;
  for (const Formattable& value : values) {
    const std::size_t place = format.find("{}", from);
    text += format.substr(from, place - from);
    value.append_to(text);
    from = place + 2;
  }
  return text += format.substr(from);
}

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

namespace {

// Based on: Damerau, "A technique for computer detection and correction of spelling errors", 1964
// (the restricted form, in which a swapped pair is not edited again).

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) cost[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) cost[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      cost[i][j] = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1,
                             cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
      }
    }
  }
  return cost[a.size()][b.size()];
}

// Words are cut short, too: the shortest that goes on from it.
std::optional<std::string_view> completed(std::string_view word,
                                          std::span<const std::string_view> candidates) {
  constexpr std::size_t kFewest = 2;  // letters
  const std::size_t letters = word.size() - std::min(word.find_first_not_of('-'), word.size());
  if (letters < kFewest) return std::nullopt;
  std::optional<std::string_view> best;
  for (const std::string_view candidate : candidates)
    if (candidate.starts_with(word) && (!best || candidate.size() < best->size())) best = candidate;
  return best;
}

}  // namespace

std::optional<std::string_view> nearest(std::string_view word,
                                        std::span<const std::string_view> candidates) {
  // Longer words are no slips of ours, and the table of distances would grow with their square.
  constexpr std::size_t kLongestWord = 64;
  if (word.size() > kLongestWord) return std::nullopt;
  const std::size_t limit = std::max<std::size_t>(2, word.size() / 3);
  std::optional<std::string_view> best;
  std::size_t best_distance = limit + 1;
  for (const std::string_view candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance && distance < candidate.size()) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best ? best : completed(word, candidates);
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates) {
  const auto found = nearest(word, candidates);
  return found ? "; did you mean " + std::string(*found) + "?" : std::string();
}

// Messages quote what came from outside: hosts can take them as text.
Error::Error(ErrorCode code, const std::string& message, std::int64_t element)
    : std::runtime_error(visible_lines(message)), code_(code), element_(element) {}

Failure current_failure(const char* out_of_memory) noexcept {
  try {
    throw;
  } catch (const Error& error) {
    return {error.code(), error.what(), error.element()};
  } catch (const std::bad_alloc&) {
    return {ErrorCode::OutOfMemory, out_of_memory};
  } catch (const std::length_error&) {
    return {ErrorCode::OutOfMemory, out_of_memory};
  } catch (const std::exception& error) {
    return {{}, error.what()};
  } catch (...) {
    return {{}, "an unknown exception"};
  }
}

void refuse(std::string_view where, const std::string& what) {
  throw Error(ErrorCode::InvalidArgument, std::string(where) + ": " + what);
}

std::size_t memory_size(std::uint64_t bytes, std::string_view where) {
  constexpr std::size_t kMore = std::size_t{1} << 20;  // what readers put around them
  if (bytes > std::vector<std::byte>().max_size() - kMore)
    throw Error(ErrorCode::OutOfMemory,
                formatted("{}: {} bytes are more than this program can hold; a 64-bit one can",
                          where, bytes));
  return static_cast<std::size_t>(bytes);
}

void assertion_failed(const char* condition, const char* file, int line) {
  throw std::logic_error(std::string(file) + ":" + std::to_string(line) +
                         ": assertion failed: " + condition);
}

}  // namespace planish
