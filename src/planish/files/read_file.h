#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace planish {

/// The whole file as bytes; pipes too. Throws Error{UnreadableInput} with the system's reason.
[[nodiscard]] std::vector<std::byte> read_file(const std::filesystem::path& path);

}  // namespace planish
