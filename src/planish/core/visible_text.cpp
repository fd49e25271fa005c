#include "planish/core/visible_text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>

#include "planish/core/utf8.h"

namespace planish {
namespace {

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

std::string visible(std::string_view text) { return with_escapes(text, escaped); }

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

}  // namespace planish
