#include "planish/files/shared/text_lines.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "planish/core/error.h"
#include "planish/core/parallel.h"

namespace planish {
namespace {

// By byte.
constexpr std::array<bool, 256> kIsBlank = [] {
  std::array<bool, 256> blank{};
  for (const char c : {' ', '\t', '\r', '\n', '\v', '\f'})
    blank[static_cast<unsigned char>(c)] = true;
  return blank;
}();

bool is_blank(char c) { return kIsBlank[static_cast<unsigned char>(c)]; }

}  // namespace

std::string_view Words::next() {
  const auto blank = [&](const char* at) {
    return is_blank(*at) || (*at == '\\' && at + 1 < end_ && (at[1] == '\n' || at[1] == '\r'));
  };
  while (at_ < end_ && blank(at_)) ++at_;
  if (at_ < end_ && *at_ == '#') at_ = end_;
  const char* begin = at_;
  while (at_ < end_ && !blank(at_)) ++at_;
  return {begin, static_cast<std::size_t>(at_ - begin)};
}

void LineNote::add(std::int64_t at_line, std::string_view fault, std::int64_t at_element) {
  if (count++ > 0) return;
  line = at_line;
  element = at_element;
  what = fault;
}

void LineNote::join(const LineNote& behind, std::int64_t lines_before,
                    std::int64_t elements_before) {
  if (count == 0 && behind.count > 0) {
    line = behind.line + lines_before;
    element = behind.element < 0 ? -1 : behind.element + elements_before;
    what = behind.what;
  }
  count += behind.count;
}

void LineNote::warn(std::vector<Warning>& warnings, const std::string& code, std::string_view name,
                    std::string_view done) const {
  if (count == 0) return;
  std::string place(name);
  if (line > 0) place += formatted(":{}", line);
  const std::string times = count > 1 ? formatted(" ({} times)", count) : "";
  warnings.push_back({.code = code,
                      .message = formatted("{}: {}; {}{}", place, what, done, times),
                      .count = count,
                      .first = element});
}

TextLines::TextLines(const FileBytes& file, Continuation continuation)
    : text_(reinterpret_cast<const char*>(file.bytes.data()), file.bytes.size()),
      name_(file.name),
      continuation_(continuation),
      is_strict_(file.is_strict),
      progress_(file.progress),
      terminator_(text_.find('\n') == std::string_view::npos ? '\r' : '\n') {}

TextLines TextLines::of_header(const FileBytes& file) {
  TextLines lines(file);
  const std::size_t end = lines.text_.find_first_of("\r\n");
  const bool is_return = end != std::string_view::npos && lines.text_[end] == '\r' &&
                         lines.text_.substr(end + 1, 1) != "\n";
  if (is_return) lines.terminator_ = '\r';
  return lines;
}

void TextLines::count_from(std::int64_t lines_before) {
  number_ = lines_before;
  next_number_ = lines_before + 1;
}

void TextLines::move_before(const TextLines& part) {
  position_ = static_cast<std::size_t>(part.text_.data() - text_.data());
  count_from(part.number_);
}

std::size_t TextLines::end_of_line(std::size_t from) const {
  if (from >= text_.size()) return text_.size();
  const void* found = std::memchr(text_.data() + from, terminator_, text_.size() - from);
  return found ? static_cast<std::size_t>(static_cast<const char*>(found) - text_.data())
               : text_.size();
}

TextLines TextLines::part(std::size_t begin, std::size_t end) const {
  TextLines lines = *this;
  lines.text_ = text_.substr(begin, end - begin);
  lines.line_ = {};
  lines.position_ = 0;
  lines.number_ = 0;
  lines.next_number_ = 1;
  return lines;
}

std::vector<TextLines> TextLines::cut(std::size_t part_bytes) const {
  std::vector<TextLines> parts;
  for (std::size_t begin = 0; begin < text_.size();) {
    const std::size_t end = start_of_line(begin + std::min(part_bytes, text_.size()));
    parts.push_back(part(begin, end));
    begin = end;
  }
  if (parts.empty()) parts.push_back(part(0, 0));
  return parts;
}

std::size_t TextLines::start_of_line(std::size_t from) const {
  if (from == 0) return 0;
  for (std::size_t end = end_of_line(from - 1); end < text_.size(); end = end_of_line(end + 1)) {
    const std::size_t last = end > 0 && text_[end - 1] == '\r' ? end - 1 : end;
    const bool goes_on =
        continuation_ == Continuation::Backslash && last > 0 && text_[last - 1] == '\\';
    if (!goes_on) return end + 1;
  }
  return text_.size();
}

bool TextLines::next() {
  if (position_ >= text_.size()) return false;
  stop_.step();
  number_ = next_number_;
  const std::size_t begin = position_;
  std::size_t end = end_of_line(begin);
  const auto ends_with_backslash = [&] {
    std::size_t last = end;
    if (last > begin && text_[last - 1] == '\r') --last;
    return last > begin && text_[last - 1] == '\\';
  };
  ++next_number_;
  // A path at the end of a comment may end with a backslash too.
  if (continuation_ == Continuation::Backslash && text_[begin] != '#') {
    while (end < text_.size() && ends_with_backslash()) {
      end = end_of_line(end + 1);
      ++next_number_;
    }
  }
  position_ = end + (end < text_.size());
  if (end > begin && text_[end - 1] == '\r') --end;
  line_ = text_.substr(begin, end - begin);
  return true;
}

bool TextLines::next_with_words() {
  while (next())
    if (!Words(line_).next().empty()) return true;
  return false;
}

void TextLines::fail(const std::string& what, std::int64_t element) const {
  fail_at(std::max<std::int64_t>(number_, 1), what, element);
}

void TextLines::note_at(LineNote& note, std::int64_t line, const std::string& what,
                        std::int64_t element) const {
  if (is_strict_) fail_at(std::max<std::int64_t>(line, 1), what, element);
  note.add(line, what, element);
}

void TextLines::fail_at(std::int64_t line, const std::string& what, std::int64_t element) const {
  throw Error(ErrorCode::UnreadableInput, formatted("{}:{}: {}", name_, line, what), element);
}

std::vector<TextLines> numbered_parts(const TextLines& lines, std::size_t part_bytes) {
  std::vector<TextLines> parts = lines.rest().cut(part_bytes);
  std::vector<std::int64_t> counts(parts.size());
  parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      TextLines part = parts[p];
      while (part.next()) continue;
      counts[p] = part.lines_passed();
      part.count();
    }
  });
  std::int64_t before = lines.lines_passed();
  for (std::size_t p = 0; p < parts.size(); ++p) {
    parts[p].count_from(before);
    before += counts[p];
  }
  return parts;
}

}  // namespace planish
