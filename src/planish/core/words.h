#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
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

/// Length in bytes of the well-formed UTF-8 sequence at the start of `text`, which is not empty;
/// 0 where none stands there.
[[nodiscard]] std::size_t utf8_length(std::string_view text);

/// Text whose invisible code points (error.cpp) stand as escape() says, bytes that are no UTF-8 as
/// `\xff`.
[[nodiscard]] std::string with_escapes(std::string_view text, std::string (*escape)(std::uint32_t));

/// A path's text, and the path of a text, in UTF-8 on every system: std::filesystem's own narrow
/// texts are in Windows' code page. Bytes that are no UTF-8 stay, where paths are bytes.
[[nodiscard]] std::string utf8(const std::filesystem::path& path);
[[nodiscard]] std::filesystem::path path_of(std::string_view text);

/// Text from outside (a file's name, an argument) as it may stand in a message: what would move
/// the cursor, turn the line round or be seen by nobody (control characters, bidirectional
/// overrides, characters without width) as `\x1b`, `\n`, `\u202e`; bytes that are no UTF-8 as
/// `\xff`. All else stays as it is.
[[nodiscard]] std::string visible(std::string_view text);
[[nodiscard]] inline std::string visible(const std::string& text) {
  return visible(std::string_view(text));
}
[[nodiscard]] inline std::string visible(const std::filesystem::path& path) {
  return visible(utf8(path));
}
/// The same in double quotes.
[[nodiscard]] std::string in_double_quotes(std::string_view text);

/// Text as it may stand in a line of a file that others read: each control (error.cpp) is `other`.
/// Bytes that are no UTF-8 stay: they are letters of an older encoding.
[[nodiscard]] std::string without_controls(std::string_view text, char other);

/// What visible() says for a text of several lines: `\n` stays.
[[nodiscard]] std::string visible_lines(std::string_view text);

/// The candidate that `word` is most likely a slip of: fewest inserted, deleted, replaced or
/// swapped letters, at most a third of its length (but 2 at least). Of equally near ones the first.
/// Else the shortest that `word` is the beginning of.
[[nodiscard]] std::optional<std::string_view> nearest(std::string_view word,
                                                      std::span<const std::string_view> candidates);

/// "; did you mean X?" or nothing.
[[nodiscard]] std::string did_you_mean(std::string_view word,
                                       std::span<const std::string_view> candidates);

}  // namespace planish
