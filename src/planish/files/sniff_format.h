#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "planish/files/formats.h"

namespace planish {

/// The format that a file's first bytes speak for: the magic of GLB, LAS, PLY, OFF and PCD, the
/// size of a binary STL, else what the first lines look like (JSON, `solid`, OBJ's keywords,
/// numbers). Empty where nothing is recognised. `bytes` is the whole file.
[[nodiscard]] std::optional<FileFormat> sniff_format(std::span<const std::byte> bytes);

/// What a file is that stands in the place of one, and the remedy: "is compressed by gzip; ...".
/// Empty where its first bytes do not say so.
[[nodiscard]] std::string_view foreign_content(std::span<const std::byte> bytes);

}  // namespace planish
