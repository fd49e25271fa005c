#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>

/// What differs from system to system. Only the sources beside this header include a system's own
/// (a test), posix.cpp and windows.cpp, of which a build has one. Errors are told as
/// std::filesystem tells them, in its generic category wherever that has the reason.
namespace planish::platform {

/// An open file by its number in the C library, which every system has. Closed with this.
class File {
 public:
  File() = default;
  explicit File(int number) : number_(number) {}
  File(File&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  File& operator=(File&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~File() { (void)close(); }

  [[nodiscard]] bool is_open() const { return number_ >= 0; }
  [[nodiscard]] int number() const { return number_; }
  /// Where errors of networks and quotas come to light.
  std::error_code close();

 private:
  int number_ = -1;
};

enum class FileKind { Regular, Folder, CharacterDevice, Other };
struct FileFacts {
  FileKind kind = FileKind::Other;
  std::uint64_t size = 0;  ///< 0 of pipes, and of files that are made as they are read
};

/// Files that others hold open like this can be renamed and removed all the same.
[[nodiscard]] File open_to_read(const std::filesystem::path& path, std::error_code& error);
/// The same of what was a regular file a moment ago: whatever has taken its place meanwhile, no
/// link is followed, nobody waited for and no terminal taken.
[[nodiscard]] File open_regular_to_read(const std::filesystem::path& path, std::error_code& error);
/// A file of this name that was not there, with the permissions that the user gives new files.
[[nodiscard]] File create_new(const std::filesystem::path& path, std::error_code& error);

[[nodiscard]] FileFacts facts_of(int file, std::error_code& error);
/// How many bytes were read: 0 at the end. Signals do not end it.
[[nodiscard]] std::size_t read_some(int file, std::span<std::byte> bytes, std::error_code& error);
/// The same from a place on, by any thread; of what has places.
[[nodiscard]] std::size_t read_at(int file, std::span<std::byte> bytes, std::uint64_t place,
                                  std::error_code& error);
[[nodiscard]] std::error_code write_all(int file, std::span<const std::byte> bytes);
[[nodiscard]] std::error_code set_size(int file, std::uint64_t bytes);
/// Takes room on the disk for a file of so many bytes, which may be behind its end. False where
/// this system or its disk takes none; an error only where the disk has no such room.
[[nodiscard]] bool reserve(int file, std::uint64_t bytes, std::error_code& error);

/// Gives `from` the name `to`, at once. Without `replaces` what stands at `to` stays, and the error
/// is std::errc::file_exists: also where it came a moment ago, on file systems that can rename so
/// or give a file a second name. Of folders only an empty one is replaced.
[[nodiscard]] std::error_code rename_file(const std::filesystem::path& from,
                                          const std::filesystem::path& to, bool replaces);
/// The same without `replaces` for file systems whose only tool are second names.
[[nodiscard]] std::error_code link_in_place(const std::filesystem::path& from,
                                            const std::filesystem::path& to);

/// What tells files apart behind all their names: device and file. Empty where none is there.
using FileIdentity = std::pair<std::uint64_t, std::uint64_t>;
[[nodiscard]] std::optional<FileIdentity> identity_of(const std::filesystem::path& path);
/// A path whose spelling can be compared where no file is there yet: where the system takes upper
/// and lower case for one, in one case.
[[nodiscard]] std::filesystem::path comparable(const std::filesystem::path& path);

/// Why no file can have the last part of a path for its name, with the remedy; empty: one can.
[[nodiscard]] std::string objection_to_name(const std::filesystem::path& path);

/// A name with that end behind it, which fits wherever `name` does: a long one gives up its own.
[[nodiscard]] std::filesystem::path with_end(const std::filesystem::path& name,
                                             const std::string& end);

/// Whether this user may; only opening tells for sure.
[[nodiscard]] std::error_code may_read(const std::filesystem::path& path);
[[nodiscard]] bool may_write_into(const std::filesystem::path& folder);

/// A new folder in `folder`, of a hidden name that no other has, for this user alone.
[[nodiscard]] std::filesystem::path make_temporary_folder(const std::filesystem::path& folder,
                                                          std::error_code& error);
/// Removes a folder with all that it holds, or a file, as far as that can be. Takes no memory by
/// `new`: what ran out of that ends here, and std::filesystem::remove_all() would end the process.
void remove_folder(const std::filesystem::path& folder) noexcept;

/// A file in that folder that has no name, so that nothing is left of it, whatever ends the
/// process.
[[nodiscard]] File open_nameless(const std::filesystem::path& folder, std::error_code& error);

inline constexpr int kStandardInput = 0, kStandardOutput = 1, kStandardError = 2;

}  // namespace planish::platform
