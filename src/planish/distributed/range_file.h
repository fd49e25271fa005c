#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "planish/core/raw_vector.h"

namespace planish {

/// A file of which ranks read ranges. Throws Error{UnreadableInput} naming the path and the
/// system's reason.
class RangeFile {
 public:
  explicit RangeFile(std::string path);
  ~RangeFile();
  RangeFile(const RangeFile&) = delete;
  RangeFile& operator=(const RangeFile&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::int64_t size() const { return size_; }
  /// The bytes [begin, end), cut to what the file has when it was opened.
  [[nodiscard]] RawVector<std::byte> read(std::int64_t begin, std::int64_t end) const;

 private:
  std::string path_;
  int file_ = -1;
  std::int64_t size_ = 0;
};

}  // namespace planish
