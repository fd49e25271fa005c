#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace planish {

/// 0.41 s or 12 ms or 0.3 ms.
[[nodiscard]] std::string duration(double milliseconds);

/// A third to three times as long: "under 2 s", "4 to 36 s", "1 to 9 min".
[[nodiscard]] std::string rough_duration(double seconds);

/// What messages call an input or an output: its whole path, made visible; "-" is stdin or stdout.
[[nodiscard]] std::string input_name(std::string_view path);
[[nodiscard]] std::string output_name(std::string_view path);

/// A message that says whose it is: "bust.obj: what", the name once. No name: the message.
[[nodiscard]] std::string named_message(std::string_view name, const std::string& message);

/// Valid UTF-8 without controls (without_controls()): what may stand in a file's header or in glTF.
/// Each that does not fit becomes '?', and so does a byte that is no UTF-8.
[[nodiscard]] std::string plain_utf8(std::string_view text);

}  // namespace planish
