#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"
#include "planish/files/formats.h"

namespace planish {

/// The byte order mark that editors put before text of UTF-8.
inline constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
[[nodiscard]] bool has_utf8_mark(std::span<const std::byte> bytes);

/// The size that a binary STL says it has is that of the file.
[[nodiscard]] bool is_binary_stl(std::span<const std::byte> bytes);

/// Text of UTF-16, told by its mark or by the zeros of its first letters.
[[nodiscard]] bool is_utf16(std::span<const std::byte> bytes);

struct DecodedText {
  RawVector<std::byte> bytes;         ///< UTF-8 without a mark
  std::optional<std::size_t> damage;  ///< the byte from which on it is no text of UTF-16
};
/// Of bytes that are text of UTF-16; zeros behind the text are left out.
[[nodiscard]] DecodedText decode_utf16(std::span<const std::byte> bytes);

/// A file as its reader takes it.
struct TextFile {
  FileBytes file;                ///< its bytes are the given ones or `decoded`
  RawVector<std::byte> decoded;  ///< text of UTF-16 as UTF-8
  std::vector<Warning> warnings;
};

/// Text as UTF-8 without a mark before it and without zeros behind it; binary files stay as they
/// are. Throws Error{UnreadableInput} for text of UTF-16 that is damaged, or where `file` is
/// strict.
[[nodiscard]] TextFile text_file(const FileBytes& file, FileFormat format);

}  // namespace planish
