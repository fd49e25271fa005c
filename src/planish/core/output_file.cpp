#include "planish/core/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <random>
#include <string>

#include "planish/core/error.h"
#include "planish/core/stop.h"
#include "planish/core/visible_text.h"

namespace planish {

OutputFile::OutputFile(std::filesystem::path path) : path_(std::move(path)) {
  // Unlike mkstemp, O_EXCL with mode 0666 leaves the permissions to the user's umask.
  constexpr int kAttempts = 100;
  std::random_device random;
  int descriptor = -1;
  for (int attempt = 0; descriptor < 0 && attempt < kAttempts; ++attempt) {
    temporary_ = path_.string() + "." + std::to_string(random()) + ".tmp";
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
              visible(path_) + ": cannot " + std::string(action) + ": " + std::strerror(errno));
}

void OutputFile::write(std::span<const std::byte> bytes) {
  check_stop();
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
  // close() is where network and quota errors come to light.
  const int closed = ::close(file_);
  file_ = -1;
  if (closed != 0) fail("close");
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) fail("rename the finished file to");
  temporary_.clear();
}

}  // namespace planish
