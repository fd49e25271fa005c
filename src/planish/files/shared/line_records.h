#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The lines with words behind a place of a text file, numbered from 0, in parts for threads.
class LineRecords {
 public:
  /// Those behind the current line of `lines`, in parts of about `part_bytes`.
  LineRecords(const TextLines& lines, std::size_t part_bytes)
      : parts_(lines.rest().cut(part_bytes)) {
    first_.resize(parts_.size() + 1, 0);
    parallel_for(parts_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) {
        TextLines part = parts_[p];
        while (part.next_with_words()) ++first_[p + 1];
      }
    });
    for (std::size_t p = 0; p < parts_.size(); ++p) first_[p + 1] += first_[p];
  }

  [[nodiscard]] std::int64_t count() const { return first_.back(); }
  [[nodiscard]] std::size_t part_count() const { return parts_.size(); }

  /// Calls read(part, lines, begin, end) for the records [begin, end) of each part within
  /// [first, last), on all threads; `lines` stands before the first of them. False where one threw
  /// Error{UnreadableInput}: its line counts from the part, so that the file has to be read again.
  template <class Read>
  [[nodiscard]] bool for_parts(std::int64_t first, std::int64_t last, const Read& read) const {
    std::atomic<bool> sound{true};
    parallel_for(parts_.size(), 1, [&](std::size_t begin_part, std::size_t end_part) {
      for (std::size_t p = begin_part; p < end_part; ++p) {
        const std::int64_t begin = std::max(first, first_[p]), end = std::min(last, first_[p + 1]);
        if (begin >= end || !sound.load(std::memory_order_relaxed)) continue;
        TextLines lines = parts_[p];
        for (std::int64_t record = first_[p]; record < begin; ++record)
          (void)lines.next_with_words();
        try {
          read(p, lines, begin, end);
        } catch (const Error&) {
          sound.store(false, std::memory_order_relaxed);
        }
      }
    });
    return sound.load();
  }

 private:
  std::vector<TextLines> parts_;
  std::vector<std::int64_t> first_;  // record of each part; one more at the end
};

/// The faces of one part of a file after another.
struct FaceParts {
  struct Part {
    std::vector<std::int32_t> sizes, vertices;
  };
  std::vector<Part> parts;

  /// Appends them to a mesh. False, and nothing is done, where its corners would be 2^31 or more.
  [[nodiscard]] bool append_to(PolygonMesh& mesh) const;
};

}  // namespace planish
