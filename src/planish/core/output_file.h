#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <system_error>

#include "planish/core/platform/files.h"

namespace planish {

/// A file that appears whole or not at all: bytes go to a temporary beside `path`, commit()
/// renames it. Without commit the temporary is removed and an old file stays as it was. Bytes are
/// the system's once written, not yet the disk's: who ends the process loses nothing, who cuts the
/// power may have to make the file again.
/// Every member throws Error{UnwritableOutput} naming the path and the system's reason.
class OutputFile {
 public:
  /// Without `replaces` a file that stands at `path` when commit() is called stays, and commit()
  /// throws.
  explicit OutputFile(std::filesystem::path path, bool replaces = true);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Where the bytes go until then, for whoever writes them by other means.
  [[nodiscard]] const std::filesystem::path& temporary() const { return temporary_; }

  /// Takes room for so many bytes on the disk where the system can: a disk that is too full is
  /// told before the work, writing is faster, and replacing an old file does not wait for the disk.
  /// More or fewer may be written.
  void reserve(std::uint64_t bytes);
  void write(std::span<const std::byte> bytes);
  void write(std::string_view text);
  /// Closes and renames.
  void commit();

 private:
  [[noreturn]] void fail(std::string_view action, const std::error_code& error);

  std::filesystem::path path_;
  std::filesystem::path temporary_;
  bool replaces_;
  platform::File file_;
  std::uint64_t reserved_ = 0, written_ = 0;
};

}  // namespace planish
