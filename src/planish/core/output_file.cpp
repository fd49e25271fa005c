#include "planish/core/output_file.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <random>
#include <string>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/words.h"

namespace planish {
namespace {

std::error_code result_of(int returned) {
  return returned == 0 ? std::error_code() : std::error_code(errno, std::generic_category());
}

}  // namespace

std::error_code rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                            bool replaces) {
  if (replaces) return result_of(std::rename(from.c_str(), to.c_str()));
#ifdef RENAME_NOREPLACE
  const std::error_code error =
      result_of(::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE));
  if (error != std::errc::invalid_argument && error != std::errc::function_not_supported)
    return error;
#endif
  return link_in_place(from, to);
}

std::error_code link_in_place(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::link(from.c_str(), to.c_str()) == 0) return result_of(::unlink(from.c_str()));
  if (errno == EEXIST) return result_of(-1);
  // Folders have no second names, nor have files everywhere: what comes between these two lines is
  // replaced.
  std::error_code ignored;
  if (std::filesystem::exists(std::filesystem::symlink_status(to, ignored)))
    return std::make_error_code(std::errc::file_exists);
  return result_of(std::rename(from.c_str(), to.c_str()));
}

namespace {

// A name beside `path` that fits wherever that of `path` does: a long one gives up its end.
std::filesystem::path temporary_beside(const std::filesystem::path& path, unsigned number) {
  constexpr std::size_t kShortName = 100;
  const std::string end = formatted(".{}.tmp", number);
  std::string name = path.filename().string();
  if (name.size() > kShortName) {
    std::size_t kept = name.size() - end.size();
    // No character of UTF-8 is cut: some file systems refuse such names.
    while (kept > 0 && (static_cast<unsigned char>(name[kept]) & 0xc0u) == 0x80) --kept;
    name.resize(kept);
  }
  return path.parent_path() / (name + end);
}

}  // namespace

OutputFile::OutputFile(std::filesystem::path path, bool replaces)
    : path_(std::move(path)), replaces_(replaces) {
  // Unlike mkstemp, O_EXCL with mode 0666 leaves the permissions to the user's umask.
  constexpr int kAttempts = 100;
  std::random_device random;
  int descriptor = -1;
  for (int attempt = 0; descriptor < 0 && attempt < kAttempts; ++attempt) {
    temporary_ = temporary_beside(path_, random());
    descriptor = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno != EEXIST) break;
  }
  if (descriptor < 0) {
    temporary_.clear();
    fail("create");
  }
  file_ = descriptor;
}

OutputFile::~OutputFile() {
  if (file_ >= 0) ::close(file_);
  if (!temporary_.empty()) {
    std::error_code ignored;
    std::filesystem::remove(temporary_, ignored);
  }
}

void OutputFile::fail(std::string_view action) {
  throw Error(ErrorCode::UnwritableOutput,
              formatted("{}: cannot {}: {}", visible(path_), action, std::strerror(errno)));
}

void OutputFile::reserve(std::uint64_t bytes) {
#ifdef __linux__
  if (bytes <= reserved_) return;
  const std::string action = formatted("take room for {} bytes", bytes);
  struct statvfs disk {};
  if (::fstatvfs(file_, &disk) == 0 && disk.f_bavail * disk.f_frsize < bytes) {
    // Asked all the same, some systems would fill the disk first.
    errno = ENOSPC;
    fail(action);
  }
  int failed = 0;
  do {
    failed = ::fallocate(file_, FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes));
  } while (failed != 0 && errno == EINTR);
  if (failed == 0) reserved_ = bytes;
  // Anything else means that this file system has no such call.
  if (failed != 0 && (errno == ENOSPC || errno == EDQUOT)) fail(action);
#elif defined(__EMSCRIPTEN__)
  // A file in memory is copied whenever it grows.
  if (bytes > reserved_ && ::ftruncate(file_, static_cast<off_t>(bytes)) == 0) reserved_ = bytes;
#else
  (void)bytes;
#endif
}

void OutputFile::write(std::span<const std::byte> bytes) {
  if (LimitScope* const limits = LimitScope::current()) limits->add_output(bytes.size());
  check_stop();
  written_ += bytes.size();
  while (!bytes.empty()) {
    const ssize_t count = ::write(file_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("write");
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void OutputFile::write(std::string_view text) {
  write(std::as_bytes(std::span(text.data(), text.size())));
}

void OutputFile::commit() {
  if (written_ < reserved_ && ::ftruncate(file_, static_cast<off_t>(written_)) != 0)
    fail("give back room behind");
  // close() is where network and quota errors come to light.
  const int closed = ::close(file_);
  file_ = -1;
  if (closed != 0) fail("close");
  if (const std::error_code error = rename_file(temporary_, path_, replaces_)) {
    errno = error.value();
    fail("rename the finished file to");
  }
  temporary_.clear();
}

}  // namespace planish
