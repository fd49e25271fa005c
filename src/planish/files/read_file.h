#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"
#include "planish/files/formats.h"

namespace planish {

/// The value at the beginning of `bytes`, which must hold sizeof(Value) bytes in the byte order
/// `order`; no alignment is needed.
template <class Value>
[[nodiscard]] Value load(std::span<const std::byte> bytes,
                         std::endian order = std::endian::little) {
  std::array<std::byte, sizeof(Value)> raw;
  std::copy_n(bytes.begin(), sizeof(Value), raw.begin());
  if (order != std::endian::native) std::ranges::reverse(raw);
  return std::bit_cast<Value>(raw);
}

/// How far a file is read: threads count the bytes that they are through with, and the thread that
/// made it tells their share as the step "read", as LoopProgress does. Asks `cancelled` meanwhile.
/// The callbacks must outlive it.
class ReadProgress {
 public:
  /// 0 is told at once.
  ReadProgress(const Callbacks& callbacks, std::size_t byte_count)
      : scope_(callbacks),
        callbacks_(callbacks),
        loop_(callbacks, kStep, 0, 1,
              kUnits * static_cast<std::int64_t>(std::max<std::size_t>(byte_count, 1))) {}

  /// Bytes are counted so often, 1 to 4 times; to be called before the first.
  void expect_passes(int passes) { units_ = kUnits / passes; }
  /// On any thread.
  void add(std::size_t bytes) { loop_.add(units_ * static_cast<std::int64_t>(bytes)); }
  /// All is read: tells 1.
  void finish() const { callbacks_.report(kStep, 1); }

 private:
  static constexpr const char* kStep = "read";
  static constexpr std::int64_t kUnits = 12;  // of a byte: 1, 2, 3 and 4 divide it

  const HostScope scope_;
  const Callbacks& callbacks_;
  LoopProgress loop_;
  std::int64_t units_ = kUnits;
};

/// For readers: where nobody asks, null, nothing is counted.
inline void expect_passes(const FileBytes& file, int passes) {
  if (file.progress != nullptr) file.progress->expect_passes(passes);
}
inline void count_read(ReadProgress* progress, std::size_t bytes) {
  if (progress != nullptr) progress->add(bytes);
}

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

/// The format that a file's first bytes speak for: the magic of GLB, LAS, PLY, OFF and PCD, the
/// size of a binary STL, else what the first lines look like (JSON, `solid`, OBJ's keywords,
/// numbers). Empty where nothing is recognised. `bytes` is the whole file.
[[nodiscard]] std::optional<FileFormat> sniff_format(std::span<const std::byte> bytes);

/// What a file is that stands in the place of one, and the remedy: "is compressed by gzip; ...".
/// Empty where its first bytes do not say so.
[[nodiscard]] std::string_view foreign_content(std::span<const std::byte> bytes);

}  // namespace planish
