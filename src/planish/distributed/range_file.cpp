#include "planish/distributed/range_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "planish/core/error.h"

namespace planish {

RangeFile::RangeFile(std::string path) : path_(std::move(path)) {
  const auto fail = [&](const std::string& what) {
    if (file_ >= 0) ::close(file_);
    throw Error(ErrorCode::UnreadableInput, path_ + ": " + what);
  };
  file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) fail(std::strerror(errno));
  struct stat status {};
  if (::fstat(file_, &status) != 0) fail(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) fail("is no regular file, of which ranges can be read");
  size_ = status.st_size;
}

RangeFile::~RangeFile() { ::close(file_); }

RawVector<std::byte> RangeFile::read(std::int64_t begin, std::int64_t end) const {
  constexpr std::size_t kPieceBytes = std::size_t{64} << 20;
  begin = std::clamp<std::int64_t>(begin, 0, size_);
  end = std::clamp<std::int64_t>(end, begin, size_);
  RawVector<std::byte> bytes(static_cast<std::size_t>(end - begin));
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t got =
        ::pread(file_, bytes.data() + done, std::min(bytes.size() - done, kPieceBytes),
                begin + static_cast<std::int64_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(ErrorCode::UnreadableInput, path_ + ": " + std::strerror(errno));
    if (got == 0)
      throw Error(ErrorCode::UnreadableInput,
                  formatted("{}: became shorter while it was read, at byte {}", path_,
                            begin + static_cast<std::int64_t>(done)));
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace planish
