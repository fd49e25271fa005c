#include "page/page_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "terminal/text.h"

namespace planish::command {
namespace {

struct Range {
  std::uint32_t first, last;
};

// Unicode's controls, format characters, line and paragraph separators, fillers, variation
// selectors and non-characters: what a reader cannot see, and what makes him see something else.
constexpr std::array kInvisible{
    Range{0x0000, 0x001F},   Range{0x007F, 0x009F},   Range{0x00AD, 0x00AD},
    Range{0x034F, 0x034F},   Range{0x061C, 0x061C},   Range{0x115F, 0x1160},
    Range{0x17B4, 0x17B5},   Range{0x180B, 0x180F},   Range{0x200B, 0x200F},
    Range{0x2028, 0x202F},   Range{0x2060, 0x206F},   Range{0x3164, 0x3164},
    Range{0xE000, 0xF8FF},   Range{0xFDD0, 0xFDEF},   Range{0xFE00, 0xFE0F},
    Range{0xFEFF, 0xFEFF},   Range{0xFFA0, 0xFFA0},   Range{0xFFF0, 0xFFFB},
    Range{0xFFFE, 0xFFFF},   Range{0x1BCA0, 0x1BCA3}, Range{0x1D173, 0x1D17A},
    Range{0xE0000, 0x10FFFF}};

bool is_invisible(std::uint32_t point) {
  return std::ranges::any_of(
      kInvisible, [&](const Range& range) { return point >= range.first && point <= range.last; });
}

// A code point at the start of a text; length 0 where no well-formed UTF-8 stands there.
struct Decoded {
  std::uint32_t point = 0;
  std::size_t length = 0;
};

Decoded decode(std::string_view text) {
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
  const bool surrogate = point >= 0xD800 && point <= 0xDFFF;
  if (point < kLeast[length] || point > 0x10FFFF || surrogate) return {};
  return {point, length};
}

template <class... Arguments>
std::string printed(const char* format, Arguments... arguments) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, arguments...);
  return buffer.data();
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (std::string_view("&<>\"'`").find(c) != std::string_view::npos) {
      out += "&#" + std::to_string(static_cast<int>(c)) + ";";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

std::string visible_text(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const Decoded decoded = decode(text);
    if (decoded.length == 0) {
      out += printed("\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(text[0])));
    } else if (is_invisible(decoded.point)) {
      out += printed(decoded.point > 0xFFFF ? "\\u{%x}" : "\\u%04x",
                     static_cast<unsigned>(decoded.point));
    } else {
      out += text.substr(0, decoded.length);
    }
    text.remove_prefix(std::max<std::size_t>(decoded.length, 1));
  }
  return out;
}

std::string html_text(std::string_view text) { return escaped(visible_text(text)); }

std::string html_lines(std::string_view text) {
  std::string out;
  while (true) {
    const std::size_t end = text.find('\n');
    out += html_text(text.substr(0, end));
    if (end == std::string_view::npos) return out;
    out += '\n';
    text.remove_prefix(end + 1);
  }
}

nlohmann::ordered_json visible_json(const nlohmann::ordered_json& value) {
  if (value.is_string()) return visible_text(value.get_ref<const std::string&>());
  if (!value.is_structured()) return value;
  nlohmann::ordered_json out =
      value.is_array() ? nlohmann::ordered_json::array() : nlohmann::ordered_json::object();
  for (const auto& [key, entry] : value.items()) {
    if (value.is_array()) {
      out.push_back(visible_json(entry));
    } else {
      out[visible_text(key)] = visible_json(entry);
    }
  }
  return out;
}

std::string script_json(const nlohmann::ordered_json& value) {
  std::string out;
  for (const char c : value.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace)) {
    // Within JSON these stand in strings only.
    if (c == '<' || c == '>' || c == '&') {
      out += printed("\\u%04x", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out;
}

std::string shell_word(std::string_view word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos)
    return std::string(word);
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string figure(double number) {
  if (!std::isfinite(number)) return "not finite";
  // Rounded first: 999.9 is 1,000.
  const double rounded = std::strtod(short_number(number).c_str(), nullptr);
  if (std::abs(rounded) >= 1e3 && std::abs(rounded) < 1e6)
    return with_separators(static_cast<std::int64_t>(rounded));
  return short_number(number);
}

std::string figure(const nlohmann::ordered_json& number) {
  return number.is_number() ? figure(number.get<double>()) : "not finite";
}

}  // namespace planish::command
