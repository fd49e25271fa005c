#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace planish {

/// Length in bytes of the well-formed UTF-8 sequence at the start of `text`, which is not empty;
/// 0 where none stands there.
[[nodiscard]] std::size_t utf8_length(std::string_view text);

/// Text whose invisible code points (utf8.h) stand as escape() says, bytes that are no UTF-8 as
/// `\xff`.
[[nodiscard]] std::string with_escapes(std::string_view text, std::string (*escape)(std::uint32_t));

/// Text from outside (a file's name, an argument) as it may stand in a message: what would move
/// the cursor, turn the line round or be seen by nobody (control characters, bidirectional
/// overrides, characters without width) as `\x1b`, `\n`, `\u202e`; bytes that are no UTF-8 as
/// `\xff`. All else stays as it is.
[[nodiscard]] std::string visible(std::string_view text);
[[nodiscard]] inline std::string visible(const std::string& text) {
  return visible(std::string_view(text));
}
[[nodiscard]] inline std::string visible(const std::filesystem::path& path) {
  return visible(std::string_view(path.native()));
}

/// Text as it may stand in a line of a file that others read: each control (utf8.h) is `other`.
/// Bytes that are no UTF-8 stay: they are letters of an older encoding.
[[nodiscard]] std::string without_controls(std::string_view text, char other);

/// What visible() says for a text of several lines: `\n` stays.
[[nodiscard]] std::string visible_lines(std::string_view text);

}  // namespace planish
