#pragma once

#ifndef _WIN32
#include <sys/resource.h>
#endif

#include <algorithm>
#include <bit>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace planish::test {

/// Appends the bytes of `value` in the byte order `order`.
template <class Value>
void append(std::string& bytes, std::type_identity_t<Value> value,
            std::endian order = std::endian::little) {
  std::string raw(reinterpret_cast<const char*>(&value), sizeof(Value));
  if (order != std::endian::native) raw.assign(raw.rbegin(), raw.rend());
  bytes += raw;
}

/// Text with other ends of its lines, which are "\n".
[[nodiscard]] inline std::string with_line_ends(std::string text, const std::string& line_end) {
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += line_end.size())
    text.replace(at, 1, line_end);
  return text;
}

/// A new empty folder that goes away with its content.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::random_device random;
    do {
      path_ = std::filesystem::temp_directory_path() / ("planish-" + std::to_string(random()));
    } while (!std::filesystem::create_directory(path_));
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Names and bytes of all files below a folder, by name.
[[nodiscard]] inline std::vector<std::pair<std::string, std::string>> files_below(
    const std::filesystem::path& folder) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    files.emplace_back(std::filesystem::relative(entry.path(), folder).generic_string(),
                       std::string{std::istreambuf_iterator<char>(file), {}});
  }
  std::ranges::sort(files);
  return files;
}

#ifndef _WIN32
/// No file that this process or those that it starts write grows beyond so many bytes, as on a full
/// disk, for as long as this lives: writing fails instead of a signal.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit small = before_;
    small.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*old_handler_)(int);
  rlimit before_{};
};
#endif

}  // namespace planish::test
