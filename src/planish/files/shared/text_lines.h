#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/files/formats.h"
#include "planish/files/read_file.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The byte order mark that editors put before text of UTF-8.
inline constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
[[nodiscard]] bool has_utf8_mark(std::span<const std::byte> bytes);

/// The size that a binary STL says it has is that of the file.
[[nodiscard]] bool is_binary_stl(std::span<const std::byte> bytes);

/// Text of UTF-16, told by its mark or by the zeros of its first letters.
[[nodiscard]] bool is_utf16(std::span<const std::byte> bytes);

struct DecodedText {
  RawVector<std::byte> bytes;         ///< UTF-8 without a mark
  std::optional<std::size_t> damage;  ///< the byte from which on it is no text of UTF-16
};
/// Of bytes that are text of UTF-16; zeros behind the text are left out.
[[nodiscard]] DecodedText decode_utf16(std::span<const std::byte> bytes);

/// A file as its reader takes it.
struct TextFile {
  FileBytes file;                ///< its bytes are the given ones or `decoded`
  RawVector<std::byte> decoded;  ///< text of UTF-16 as UTF-8
  std::vector<Warning> warnings;
};

/// Text as UTF-8 without a mark before it and without zeros behind it; binary files stay as they
/// are. Throws Error{UnreadableInput} for text of UTF-16 that is damaged, or where `file` is
/// strict.
[[nodiscard]] TextFile text_file(const FileBytes& file, FileFormat format);

/// Of several parts of a file that are read side by side, the failure of the first that is wrong:
/// the one that reading them one after another would meet.
class FirstFailure {
 public:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  /// Calls read() unless a part before has failed, and keeps the Error{UnreadableInput} that it
  /// throws.
  template <class Read>
  void watch(std::size_t part, const Read& read) {
    if (part > part_.load(std::memory_order_relaxed)) return;
    try {
      read();
    } catch (const Error& error) {
      if (error.code() != ErrorCode::UnreadableInput) throw;
      const std::lock_guard lock(mutex_);
      if (part >= part_.load(std::memory_order_relaxed)) return;
      part_.store(part, std::memory_order_relaxed);
      failure_ = std::current_exception();
    }
  }

  /// The first part that failed; kNone if none did.
  [[nodiscard]] std::size_t part() const { return part_.load(std::memory_order_relaxed); }
  /// Throws it, if there is one, where the part's elements count from `elements_before`.
  void rethrow(std::int64_t elements_before = 0) const {
    if (!failure_) return;
    try {
      std::rethrow_exception(failure_);
    } catch (const Error& error) {
      if (error.element() < 0 || elements_before == 0) throw;
      throw Error(error.code(), error.what(), error.element() + elements_before);
    }
  }

 private:
  std::mutex mutex_;
  std::atomic<std::size_t> part_{kNone};
  std::exception_ptr failure_;
};

/// Words of a line, separated by blanks; a word that begins with `#` ends the line. A backslash
/// before a line break counts as a blank.
class Words {
 public:
  explicit Words(std::string_view line) : at_(line.data()), end_(at_ + line.size()) {}

  /// The next word; empty at the end.
  [[nodiscard]] std::string_view next();
  /// Everything that was not taken yet.
  [[nodiscard]] std::string_view rest() const {
    return {at_, static_cast<std::size_t>(end_ - at_)};
  }

 private:
  const char* at_;
  const char* end_;
};

/// What a reader made the best of: how often, and where first.
struct LineNote {
  std::int64_t count = 0, line = 0;  ///< line 0: of a binary file
  std::int64_t element = -1;
  std::string what;

  void add(std::int64_t at_line, std::string_view fault, std::int64_t at_element = -1);
  /// Adds that of the lines behind, whose lines and elements count from these.
  void join(const LineNote& behind, std::int64_t lines_before = 0,
            std::int64_t elements_before = 0);
  /// `name:line: what; done`, where there was anything.
  void warn(std::vector<Warning>& warnings, const std::string& code, std::string_view name,
            std::string_view done) const;
};

/// Walks through the lines of a text file; LF, CRLF and CR line ends.
class TextLines {
 public:
  enum class Continuation { None, Backslash };

  explicit TextLines(const FileBytes& file, Continuation continuation = Continuation::None);
  /// Those of a header before bytes that are no text: its first line tells how lines end.
  [[nodiscard]] static TextLines of_header(const FileBytes& file);

  /// The lines from `begin` to `end`, both places of start_of_line(), counted from 1 again.
  [[nodiscard]] TextLines part(std::size_t begin, std::size_t end) const;
  /// The lines behind the current one, counted from 1 again.
  [[nodiscard]] TextLines rest() const { return part(position_, text_.size()); }
  /// Numbers lines as so many more stood before them.
  void count_from(std::int64_t lines_before);
  /// Moves to where `part`, a numbered one of the same text, begins.
  void move_before(const TextLines& part);
  /// Parts of about `part_bytes`, at least one, none of which cuts a line.
  [[nodiscard]] std::vector<TextLines> cut(std::size_t part_bytes) const;
  /// The first place at or behind `from` where a line begins, or the end; continued lines are one.
  [[nodiscard]] std::size_t start_of_line(std::size_t from) const;

  /// Moves to the next line; false at the end of the file.
  [[nodiscard]] bool next();
  /// Moves to the next line that is neither blank nor a comment.
  [[nodiscard]] bool next_with_words();
  /// The current line without its end; continued lines are one.
  [[nodiscard]] std::string_view line() const { return line_; }
  /// The current line begins where `part` of the same text does, or behind.
  [[nodiscard]] bool is_at_or_behind(const TextLines& part) const {
    return line_.data() >= part.text_.data();
  }
  /// 1-based number of the (first) current line.
  [[nodiscard]] std::int64_t number() const { return number_; }
  /// How many lines of the file have been met, with the current one; continued ones count singly.
  [[nodiscard]] std::int64_t lines_passed() const { return next_number_ - 1; }
  /// Counts all of its bytes as read.
  void count() const { count_share(1, 1); }
  /// The same for `steps` of `of` equal steps.
  void count_share(std::int64_t steps, std::int64_t of) const {
    count_read(progress_,
               static_cast<std::size_t>(static_cast<double>(text_.size()) *
                                        static_cast<double>(steps) / static_cast<double>(of)));
  }
  /// Bytes after the current line.
  [[nodiscard]] std::size_t bytes_left() const { return text_.size() - position_; }

  /// Throws Error{UnreadableInput} `name:line: what`, at the current line or at `line`.
  [[noreturn]] void fail(const std::string& what, std::int64_t element = -1) const;
  [[noreturn]] void fail_at(std::int64_t line, const std::string& what,
                            std::int64_t element = -1) const;
  /// Notes what is not as it should be, of which the reader knows what to make; a strict file
  /// fails.
  void note(LineNote& note, const std::string& what, std::int64_t element = -1) const {
    note_at(note, number_, what, element);
  }
  void note_at(LineNote& note, std::int64_t line, const std::string& what,
               std::int64_t element = -1) const;

 private:
  [[nodiscard]] std::size_t end_of_line(std::size_t from) const;

  std::string_view text_;
  std::string name_;
  Continuation continuation_;
  bool is_strict_;
  ReadProgress* progress_;
  char terminator_;
  std::string_view line_;
  std::size_t position_ = 0;
  std::int64_t number_ = 0;
  std::int64_t next_number_ = 1;
  StopCheck stop_;
};

/// The words behind the current line of a text, whatever its lines are.
class FreeWords {
 public:
  explicit FreeWords(const TextLines& lines) : lines_(lines), words_("") {}

  /// The next word; empty at the end of the file.
  [[nodiscard]] std::string_view next() {
    std::string_view word = words_.next();
    while (word.empty() && lines_.next_with_words()) {
      words_ = Words(lines_.line());
      word = words_.next();
    }
    return word;
  }
  /// At the line of the word that was taken last.
  [[nodiscard]] const TextLines& lines() const { return lines_; }
  [[nodiscard]] std::size_t bytes_left() const {
    return words_.rest().size() + lines_.bytes_left();
  }

 private:
  TextLines lines_;
  Words words_;
};

/// Bytes of a part of a text file that a thread reads at a time.
inline constexpr std::size_t kTextPartBytes = std::size_t{1} << 20;

/// The lines behind the current one in parts of about `part_bytes`, numbered as in the file.
[[nodiscard]] std::vector<TextLines> numbered_parts(const TextLines& lines, std::size_t part_bytes);

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
