#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace planish {

/// A piece of a file as it may stand in a message: in back quotes, clipped, control bytes as `?`.
[[nodiscard]] std::string quote(std::string_view text);

/// A finite decimal number that fills `token`, whatever the locale. False: `value` is unchanged.
[[nodiscard]] bool parse_number(std::string_view token, double& value);
/// An integer that fills `token`.
[[nodiscard]] bool parse_integer(std::string_view token, std::int64_t& value);

/// A word that programs write for what is no number: `nan`, `-nan(ind)`, `1.#QNAN`.
[[nodiscard]] bool is_nan_word(std::string_view word);
/// Such a word, or one for an infinite number: `inf`, `-Infinity`, `1.#INF`.
[[nodiscard]] bool is_non_finite_word(std::string_view word);
/// What is to be said of a word that parse_number() does not take.
[[nodiscard]] std::string no_finite_number(std::string_view word);

/// The shortest text that is read back as the same number.
[[nodiscard]] std::string shortest(double value);

/// Three significant digits, as short as they go: 4.12e-07, 0.00123.
[[nodiscard]] std::string short_number(double number);

}  // namespace planish
