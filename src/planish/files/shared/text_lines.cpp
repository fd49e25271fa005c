#include "planish/files/shared/text_lines.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "planish/core/error.h"

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

TextLines::TextLines(std::span<const std::byte> bytes, std::string_view name,
                     Continuation continuation)
    : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
      name_(name),
      continuation_(continuation),
      terminator_(text_.find('\n') == std::string_view::npos ? '\r' : '\n') {}

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

void TextLines::fail_at(std::int64_t line, const std::string& what, std::int64_t element) const {
  throw Error(ErrorCode::UnreadableInput, name_ + ":" + std::to_string(line) + ": " + what,
              element);
}

}  // namespace planish
