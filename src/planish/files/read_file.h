#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"

namespace planish {

/// The whole file as bytes, read on all threads; pipes too, on one. Throws Error{UnreadableInput}
/// with the system's reason. Progress is told as the step
/// "read". (Mapped memory would end the program where a file is cut short while
/// it is read.)
[[nodiscard]] RawVector<std::byte> read_file(const std::filesystem::path& path,
                                             const Callbacks& callbacks = {});

/// A file that another names, or its first `most` bytes; nothing where it cannot be read.
[[nodiscard]] std::optional<RawVector<std::byte>> read_beside(
    const std::filesystem::path& path,
    std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

/// The share of reading a file that bringing it into memory takes where it is cached.
inline constexpr double kFileLoaded = 0.1;

}  // namespace planish
