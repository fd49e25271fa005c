#include "planish/job/text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "planish/core/visible_text.h"

namespace planish {
namespace {

std::string printed(const char* format, double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

}  // namespace

std::string duration(double milliseconds) {
  if (milliseconds >= 1000) return printed("%.2f s", milliseconds / 1000);
  return printed(milliseconds >= 10 ? "%.0f ms" : "%.1f ms", milliseconds);
}

std::string rough_duration(double seconds) {
  const double unit = seconds < 100 ? 1 : 60;
  const double least = seconds / unit / 3;
  return (least < 1 ? "under " : printed("%.0f to ", least)) +
         printed(unit > 1 ? "%.0f min" : "%.0f s", std::max(1.0, std::ceil(3 * seconds / unit)));
}

std::string input_name(std::string_view path) { return path == "-" ? "stdin" : visible(path); }

std::string output_name(std::string_view path) { return path == "-" ? "stdout" : visible(path); }

std::string named_message(std::string_view name, const std::string& message) {
  if (name.empty() || message.starts_with(std::string(name) + ":")) return message;
  return std::string(name) + ": " + message;
}

std::string plain_utf8(std::string_view text) {
  const std::string plain = without_controls(text, '?');
  std::string out;
  for (std::string_view rest = plain; !rest.empty();) {
    const std::size_t length = utf8_length(rest);
    out += length == 0 ? std::string_view("?") : rest.substr(0, length);
    rest.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

}  // namespace planish
