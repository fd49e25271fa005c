#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace planish {

/// The media type of an image by its first bytes, else by the extension of its name:
/// "image/png". "application/octet-stream" where neither tells.
[[nodiscard]] std::string image_type(std::span<const std::byte> bytes, std::string_view name);

}  // namespace planish
