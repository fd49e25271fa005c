#include "planish/core/output_file.h"

#include <random>
#include <string>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/words.h"

namespace planish {

OutputFile::OutputFile(std::filesystem::path path, bool replaces)
    : path_(std::move(path)), replaces_(replaces) {
  constexpr int kAttempts = 100;
  std::random_device random;
  std::error_code error;
  for (int attempt = 0; !file_.is_open() && attempt < kAttempts; ++attempt) {
    temporary_ =
        path_.parent_path() / platform::with_end(path_.filename(), formatted(".{}.tmp", random()));
    file_ = platform::create_new(temporary_, error);
    if (error && error != std::errc::file_exists) break;
  }
  if (!file_.is_open()) {
    temporary_.clear();
    fail("create", error);
  }
}

OutputFile::~OutputFile() {
  (void)file_.close();  // Windows removes no open file
  if (!temporary_.empty()) {
    std::error_code ignored;
    std::filesystem::remove(temporary_, ignored);
  }
}

void OutputFile::fail(std::string_view action, const std::error_code& error) {
  throw Error(ErrorCode::UnwritableOutput,
              formatted("{}: cannot {}: {}", visible(path_), action, error.message()));
}

void OutputFile::reserve(std::uint64_t bytes) {
  if (bytes <= reserved_) return;
  std::error_code error;
  if (platform::reserve(file_.number(), bytes, error)) reserved_ = bytes;
  if (error) fail(formatted("take room for {} bytes", bytes), error);
}

void OutputFile::write(std::span<const std::byte> bytes) {
  if (LimitScope* const limits = LimitScope::current()) limits->add_output(bytes.size());
  check_stop();
  written_ += bytes.size();
  if (const std::error_code error = platform::write_all(file_.number(), bytes))
    fail("write", error);
}

void OutputFile::write(std::string_view text) {
  write(std::as_bytes(std::span(text.data(), text.size())));
}

void OutputFile::commit() {
  if (written_ < reserved_)
    if (const std::error_code error = platform::set_size(file_.number(), written_))
      fail("give back room behind", error);
  if (const std::error_code error = file_.close()) fail("close", error);
  if (const std::error_code error = platform::rename_file(temporary_, path_, replaces_))
    fail("rename the finished file to", error);
  temporary_.clear();
}

}  // namespace planish
