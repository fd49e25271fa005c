#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/files/shared/first_failure.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The lines with words behind a place of a text file, numbered from 0, in parts for threads.
class LineRecords {
 public:
  /// Those behind the current line of `lines` of `file`, in parts of about `part_bytes`. Each byte
  /// is read twice: when lines are counted, and as a record.
  LineRecords(const FileBytes& file, const TextLines& lines, std::size_t part_bytes);

  [[nodiscard]] std::int64_t count() const { return first_.back(); }
  [[nodiscard]] std::size_t part_count() const { return parts_.size(); }
  /// All lines of the file, where the record before `record` is the current one.
  [[nodiscard]] TextLines before(std::int64_t record) const;

  /// Calls read(part, lines, begin, end) for the records [begin, end) of each part within
  /// [first, last), on all threads; `lines` stands before the first of them. Throws the
  /// Error{UnreadableInput} of the first record that is wrong, and one naming `what` where there
  /// are fewer than `last`.
  template <class Read>
  void for_parts(std::int64_t first, std::int64_t last, const std::string& what,
                 const Read& read) const {
    FirstFailure failure;
    parallel_for(parts_.size(), 1, [&](std::size_t begin_part, std::size_t end_part) {
      for (std::size_t p = begin_part; p < end_part; ++p) {
        const std::int64_t begin = std::max(first, first_[p]), end = std::min(last, first_[p + 1]);
        if (begin >= end) continue;
        failure.watch(p, [&] {
          TextLines lines = parts_[p];
          for (std::int64_t record = first_[p]; record < begin; ++record)
            (void)lines.next_with_words();
          read(p, lines, begin, end);
          lines.count_share(end - begin, first_[p + 1] - first_[p]);
        });
      }
    });
    failure.rethrow();
    if (count() < last) fail_at_end(what, count() - first, last - first);
  }

 private:
  [[noreturn]] void fail_at_end(const std::string& what, std::int64_t index,
                                std::int64_t total) const;

  TextLines start_;
  std::vector<TextLines> parts_;
  std::vector<std::int64_t> first_;  // record of each part; one more at the end
  std::int64_t last_line_ = 0;
};

/// The faces of one part of a file after another.
struct FaceParts {
  struct Part {
    std::vector<std::int32_t> sizes, vertices;
  };
  std::vector<Part> parts;

  /// Appends them to a mesh. Returns the face with which its corners would be 2^31 or more, and
  /// nothing is done; -1 where all is well.
  [[nodiscard]] std::int64_t append_to(PolygonMesh& mesh) const;
};

}  // namespace planish
