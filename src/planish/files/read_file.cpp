#include "planish/files/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/memory_size.h"
#include "planish/core/parallel.h"
#include "planish/core/stop.h"
#include "planish/core/visible_text.h"
#include "planish/files/shared/read_progress.h"

namespace planish {
namespace {

[[noreturn]] void fail_to_read(const std::filesystem::path& path, int error) {
  throw Error(ErrorCode::UnreadableInput, visible(path) + ": cannot read: " + std::strerror(error));
}

struct Descriptor {
  int number;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

// Pipes have no places.
ssize_t read_at(int file, std::span<std::byte> bytes, std::size_t place, bool has_places) {
  ssize_t got = 0;
  do {
    got = has_places ? ::pread(file, bytes.data(), bytes.size(), static_cast<off_t>(place))
                     : ::read(file, bytes.data(), bytes.size());
  } while (got < 0 && errno == EINTR);
  return got;
}

// Fills as much as can be read from the beginning without a gap, on all threads; returns how much.
std::size_t read_pieces(int file, std::span<std::byte> bytes, ReadProgress& progress) {
  constexpr std::size_t kPiece = std::size_t{4} << 20;
  std::vector<std::size_t> filled((bytes.size() + kPiece - 1) / kPiece, 0);
  parallel_each(filled.size(), 1, [&](std::size_t p) {
    const auto piece = bytes.subspan(p * kPiece, std::min(kPiece, bytes.size() - p * kPiece));
    while (filled[p] < piece.size()) {
      const ssize_t got =
          read_at(file, piece.subspan(filled[p]), p * kPiece + filled[p], /*has_places=*/true);
      if (got <= 0) break;
      filled[p] += static_cast<std::size_t>(got);
    }
    progress.add(filled[p]);
  });
  std::size_t used = 0;
  for (const std::size_t count : filled) {
    used += count;
    if (count < kPiece) break;
  }
  return used;
}

RawVector<std::byte> read_start(const std::filesystem::path& path, std::uint64_t most,
                                const Callbacks& callbacks) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.number < 0) fail_to_read(path, errno);
  struct stat status {};
  if (::fstat(file.number, &status) != 0) fail_to_read(path, errno);
  if (S_ISDIR(status.st_mode)) fail_to_read(path, EISDIR);
  // Pipes and /proc say 0 bytes, and files may grow: the size is only a first guess. One byte more
  // tells the end.
  constexpr std::size_t kPiece = std::size_t{1} << 16;
  const std::size_t size = memory_size(
      std::min<std::uint64_t>(static_cast<std::uint64_t>(status.st_size), most), visible(path));
  RawVector<std::byte> bytes(size > 0 ? size + 1 : kPiece);
  ReadProgress progress(callbacks, size);
  std::size_t used = read_pieces(file.number, std::span(bytes).first(size), progress);
  while (used < most) {
    check_stop();
    if (used == bytes.size()) bytes.resize(2 * bytes.size());
    const ssize_t got = read_at(file.number, std::span(bytes).subspan(used), used, size > 0);
    if (got < 0) fail_to_read(path, errno);
    if (got == 0) break;
    used += static_cast<std::size_t>(got);
  }
  bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(used, most)));
  progress.finish();
  return bytes;
}

}  // namespace

RawVector<std::byte> read_file(const std::filesystem::path& path, const Callbacks& callbacks) {
  return read_start(path, std::numeric_limits<std::uint64_t>::max(), callbacks);
}

std::optional<RawVector<std::byte>> read_beside(const std::filesystem::path& path,
                                                std::uint64_t most) {
  try {
    return read_start(path, most, {});
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;
    return std::nullopt;
  }
}

}  // namespace planish
