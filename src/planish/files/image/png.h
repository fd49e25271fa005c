#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace planish {

/// 8-bit rows, top row first, of `channels` bytes a pixel (3: RGB, 4: with alpha, not multiplied),
/// as PNG. Throws Error{OutOfMemory}.
[[nodiscard]] std::vector<std::byte> png_of(int width, int channels,
                                            std::span<const std::uint8_t> pixels);

/// RGB, as a file that appears whole or not at all. Throws Error{UnwritableOutput},
/// Error{OutOfMemory}.
void write_png(const std::filesystem::path& path, int width, std::span<const std::uint8_t> pixels);

}  // namespace planish
