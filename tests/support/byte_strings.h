#pragma once

#include <bit>
#include <string>
#include <type_traits>

namespace planish::test {

/// Appends the bytes of `value` in the byte order `order`.
template <class Value>
void append(std::string& bytes, std::type_identity_t<Value> value,
            std::endian order = std::endian::little) {
  std::string raw(reinterpret_cast<const char*>(&value), sizeof(Value));
  if (order != std::endian::native) raw.assign(raw.rbegin(), raw.rend());
  bytes += raw;
}

/// Text with other ends of its lines, which are "\n".
[[nodiscard]] inline std::string with_line_ends(std::string text, const std::string& line_end) {
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += line_end.size())
    text.replace(at, 1, line_end);
  return text;
}

}  // namespace planish::test
