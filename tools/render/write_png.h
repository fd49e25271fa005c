#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace planish::render {

/// Writes rows of 8-bit RGB, top row first, through OutputFile. `pixels` has 3 * width bytes for
/// each row. Throws Error{UnwritableOutput}, Error{OutOfMemory}.
void write_png(const std::filesystem::path& path, int width, std::span<const std::uint8_t> pixels);

}  // namespace planish::render
