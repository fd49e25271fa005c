#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace planish {

/// A code point of Unicode at the start of a text.
struct CodePoint {
  std::uint32_t value = 0;
  std::size_t length = 0;  ///< bytes; 0: no well-formed UTF-8 stands there
};

/// That at the start of `text`, which is not empty.
[[nodiscard]] CodePoint decode_utf8(std::string_view text);

/// What a reader cannot see, and what makes him see something else: Unicode's controls, format
/// characters, line and paragraph separators, fillers, variation selectors and non-characters.
[[nodiscard]] bool is_invisible(std::uint32_t code_point);

/// Of these, what ends a line for some reader or turns the direction of writing: controls, line
/// and paragraph separators, embeddings, overrides and isolates. Joiners and marks, which names of
/// many tongues need, are none.
[[nodiscard]] bool is_control(std::uint32_t code_point);

}  // namespace planish
