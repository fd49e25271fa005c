#include "planish/files/shared/identifier.h"

namespace planish {

std::string identifier_of(const std::string& name) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::string plain = name.empty() || is_digit(name.front()) ? "_" : "";
  for (const char c : name) {
    const bool is_plain = is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    plain += is_plain ? c : '_';
  }
  return plain;
}

}  // namespace planish
