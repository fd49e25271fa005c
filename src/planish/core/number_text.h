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

/// The shortest text that is read back as the same number.
[[nodiscard]] std::string shortest(double value);

}  // namespace planish
