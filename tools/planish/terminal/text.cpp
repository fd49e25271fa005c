#include "terminal/text.h"

#include <array>
#include <cstdio>

#include "planish/core/visible_text.h"

namespace planish::command {
namespace {

std::string formatted(const char* format, double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

}  // namespace

std::string with_separators(std::int64_t number) {
  std::string digits = std::to_string(number);
  const std::ptrdiff_t first = number < 0 ? 1 : 0;
  for (auto place = static_cast<std::ptrdiff_t>(digits.size()) - 3; place > first; place -= 3) {
    digits.insert(static_cast<std::size_t>(place), ",");
  }
  return digits;
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
  return formatted("%.1f ", size) + unit;
}

std::string short_number(double number) { return formatted("%.3g", number); }

std::string duration(double milliseconds) {
  if (milliseconds >= 1000) return formatted("%.2f s", milliseconds / 1000);
  return formatted(milliseconds >= 10 ? "%.0f ms" : "%.1f ms", milliseconds);
}

std::string rough_duration(double seconds) {
  if (seconds < 1) return "under 1 s";
  if (seconds < 100) return formatted("about %.0f s", seconds);
  return formatted("about %.0f min", seconds / 60);
}

std::string counted(std::int64_t count, std::string_view singular) {
  const std::string number = with_separators(count) + " ";
  if (singular == "vertex") return number + (count == 1 ? "vertex" : "vertices");
  return number + std::string(singular) + (count == 1 ? "" : "s");
}

std::string plain_utf8(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const bool control = static_cast<unsigned char>(text[0]) < 0x20 || text[0] == 0x7F;
    if (length == 0 || control) {
      out += '?';
      text.remove_prefix(1);
    } else {
      out += text.substr(0, length);
      text.remove_prefix(length);
    }
  }
  return out;
}

}  // namespace planish::command
