#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <string_view>

#include "planish/core/error.h"
#include "planish/core/number_text.h"

namespace planish {

// What writers ask of numbers before a file is in its place: readers refuse those that are not
// finite, or take them for anything.

[[nodiscard]] inline bool is_finite(double number) { return std::isfinite(number); }
template <glm::length_t kLength, class Number>
[[nodiscard]] bool is_finite(const glm::vec<kLength, Number>& vector) {
  bool all = true;
  for (glm::length_t k = 0; k < kLength; ++k) all = all && std::isfinite(vector[k]);
  return all;
}

template <class Value>
[[nodiscard]] bool all_finite(std::span<const Value> values) {
  for (const Value& value : values)
    if (!is_finite(value)) return false;
  return true;
}

/// As messages show them: "nan", "(0, nan, 1)".
[[nodiscard]] inline std::string number_words(double number) { return short_number(number); }
template <glm::length_t kLength, class Number>
[[nodiscard]] std::string number_words(const glm::vec<kLength, Number>& vector) {
  std::string words = "(";
  for (glm::length_t k = 0; k < kLength; ++k)
    words += (k == 0 ? "" : ", ") + short_number(static_cast<double>(vector[k]));
  return words + ")";
}

/// Throws Error{InvalidArgument} `name: what 4 is not finite: (0, nan, 1); ...`.
template <class Value>
[[noreturn]] void refuse_not_finite(const std::string& name, std::string_view what,
                                    std::int64_t element, const Value& value) {
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: {} {} is not finite: {}; mend what made it, or leave it out", name,
                        what, element, number_words(value)),
              element);
}

/// The same for the first of the values that is none; they are `width` an element, of which the
/// first has number `first`.
template <class Value>
void require_finite(std::span<const Value> values, std::int64_t first, std::string_view what,
                    const std::string& name, std::size_t width = 1) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!is_finite(values[i]))
      refuse_not_finite(name, what, first + static_cast<std::int64_t>(i / width), values[i]);
}

}  // namespace planish
