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

}  // namespace planish::test
