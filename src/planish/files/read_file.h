#pragma once

#include <cstddef>
#include <filesystem>

#include "planish/core/raw_vector.h"

namespace planish {

/// The whole file as bytes, read on all threads; pipes too, on one. Throws Error{UnreadableInput}
/// with the system's reason. (Mapped memory would end the program where a file is cut short while
/// it is read.)
[[nodiscard]] RawVector<std::byte> read_file(const std::filesystem::path& path);

}  // namespace planish
