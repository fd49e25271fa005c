#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace planish::command {

/// 1234567 -> "1,234,567".
[[nodiscard]] std::string with_separators(std::int64_t number);

/// 2202009 -> "2.1 MiB"; below 1 KiB in bytes.
[[nodiscard]] std::string byte_size(std::uint64_t bytes);

/// Three significant digits, as short as they go: 4.12e-07, 0.00123.
[[nodiscard]] std::string short_number(double number);

/// 0.41 s or 12 ms or 0.3 ms.
[[nodiscard]] std::string duration(double milliseconds);

/// "under 1 s", "about 12 s", "about 3 min".
[[nodiscard]] std::string rough_duration(double seconds);

/// "1 face", "2 faces"; "1 vertex", "2 vertices".
[[nodiscard]] std::string counted(std::int64_t count, std::string_view singular);

/// Valid UTF-8 without control characters: what may stand in a file's header or in glTF. Each
/// byte that does not fit becomes '?'.
[[nodiscard]] std::string plain_utf8(std::string_view text);

}  // namespace planish::command
