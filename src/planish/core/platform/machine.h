#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <system_error>

/// Memory, processor time and the name of the machine.
namespace planish::platform {

/// Bytes that this process can still take: of the machine, of the group of processes that it is in,
/// and of its own limit.
[[nodiscard]] std::uint64_t free_memory();
/// The most that has lain in memory at once, and what lies there now; 0 where the system does not
/// say.
[[nodiscard]] std::uint64_t peak_memory();
[[nodiscard]] std::uint64_t resident_memory();

/// Memory that is freed stays with the process. Every step of a job takes and frees arrays of
/// megabytes. glibc gives those back to the system at once, which then zeroes fresh pages for the
/// next step: a third of a fit's time.
void keep_freed_memory();

// Arrays by the page, for an operator new: these take no memory by it.

/// Null where there is none.
[[nodiscard]] void* map_memory(std::size_t bytes) noexcept;
/// Of an open file, whose room on the disk is taken first: a page without any would end the process
/// when it is written to. The file may be closed after. Null with the reason where there is none.
[[nodiscard]] void* map_file(int file, std::size_t bytes, std::error_code& error) noexcept;
void unmap(void* array, std::size_t bytes) noexcept;
/// Pages of a file leave memory; their content stays in the file, or on its way there.
void let_pages_go(void* array, std::size_t bytes) noexcept;
/// Mappings begin at its multiples.
inline constexpr std::size_t kLeastPage = 4096;

/// Processor time of the calling thread, and of the whole process.
[[nodiscard]] std::int64_t thread_nanoseconds();
[[nodiscard]] std::int64_t process_nanoseconds();

/// Empty where it has none.
[[nodiscard]] std::string host_name();

}  // namespace planish::platform
