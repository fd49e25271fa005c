#include "planish/job/page/page_text.h"
#include "planish/core/counted.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "planish/core/visible_text.h"
#include "planish/job/text.h"

namespace planish {
namespace {

template <class... Arguments>
std::string as_printed(const char* format, Arguments... arguments) {
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
  return with_escapes(text, [](std::uint32_t point) {
    return as_printed(point > 0xFFFF ? "\\u{%x}" : "\\u%04x", static_cast<unsigned>(point));
  });
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
      out += as_printed("\\u%04x", static_cast<unsigned>(c));
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
  // Three digits, as the viewer shows. Rounded first: 999.9 is 1,000.
  std::array<char, 32> digits;
  std::snprintf(digits.data(), digits.size(), "%.3g", number);
  const double rounded = std::strtod(digits.data(), nullptr);
  if (std::abs(rounded) >= 1e3 && std::abs(rounded) < 1e6)
    return with_separators(static_cast<std::int64_t>(rounded));
  return digits.data();
}

std::string figure(const nlohmann::ordered_json& number) {
  return number.is_number() ? figure(number.get<double>()) : "not finite";
}

}  // namespace planish
