#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"
#include "planish/files/formats.h"

namespace planish {

/// The whole file as bytes, read on all threads; pipes too, on one, as far as memory reaches. A
/// file that grows meanwhile is read as it was. Throws Error{UnreadableInput} with the system's
/// reason, and for devices that do not end; Error{OutOfMemory}. Progress is told as the step
/// "read". (Mapped memory would end the program where a file is cut short while
/// it is read.)
[[nodiscard]] RawVector<std::byte> read_file(const std::filesystem::path& path,
                                             const Callbacks& callbacks = {});

/// What is left of an open file or pipe, stdin say, which messages call `name`. Throws as above.
[[nodiscard]] RawVector<std::byte> read_stream(int file, const std::string& name);

/// Of a file that an input names, or why it cannot be had.
struct NamedFile {
  RawVector<std::byte> bytes;
  std::uint64_t size = 0;  ///< of the file
  std::string trouble;     ///< "wood.png: is a pipe, a device or a folder"; empty: none
};

/// The first `most` bytes of the file at `path`, which `input` names. Nothing is read but a regular
/// file, as long as it is when it is opened, and nothing is waited for; with FileReach::Beside only
/// what lies in the folder of `input` or below it, once links are resolved. Throws
/// Error{OutOfMemory}.
[[nodiscard]] NamedFile read_named_start(const std::filesystem::path& path,
                                         const std::filesystem::path& input, FileReach reach,
                                         std::uint64_t most);

/// Texts and pictures that an input names are no longer.
inline constexpr std::uint64_t kMostNamedBytes = std::uint64_t{1} << 30;

/// The same of a whole file of kMostNamedBytes at most.
[[nodiscard]] NamedFile read_named(const std::filesystem::path& path,
                                   const std::filesystem::path& input, FileReach reach);

/// The share of reading a file that bringing it into memory takes where it is cached.
inline constexpr double kFileLoaded = 0.1;

}  // namespace planish
