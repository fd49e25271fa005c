#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "planish/files/formats.h"

namespace planish {

/// The format that a file's first bytes speak for: the magic of GLB, PLY, OFF and PCD, the size of
/// a binary STL, else what the first lines look like (JSON, `solid`, OBJ's keywords, numbers).
/// Empty where nothing is recognised. `bytes` is the whole file.
[[nodiscard]] std::optional<FileFormat> sniff_format(std::span<const std::byte> bytes);

/// The file without the byte order mark of UTF-8 that editors put before text. Throws
/// Error{UnreadableInput} for text of UTF-16, which is told by its mark or its zeros.
[[nodiscard]] FileBytes utf8_file(const FileBytes& file, FileFormat format);

/// Throws for text of UTF-16 as above.
void refuse_utf16(std::span<const std::byte> bytes, std::string_view name);

}  // namespace planish
