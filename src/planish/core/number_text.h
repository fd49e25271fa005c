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

/// For people: three significant digits, as short as they go; large numbers as whole ones up to a
/// million: 4.12e-07, 0.00123, 12346.
[[nodiscard]] std::string short_number(double number);

/// For people, the sign included: 0.125 -> "12.5 %". None has an exponent: below 0.001 % and just
/// below all stand as such: "under 0.001 %", "over 99.9 %".
[[nodiscard]] std::string percent(double share);

/// `number` with so many decimals.
[[nodiscard]] std::string fixed(double number, int decimals);

/// 2202009 -> "2.1 MiB"; below 1 KiB in bytes.
[[nodiscard]] std::string byte_size(std::uint64_t bytes);

}  // namespace planish
