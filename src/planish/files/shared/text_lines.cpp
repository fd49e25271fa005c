#include "planish/files/shared/text_lines.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/files/read_file.h"

namespace planish {
namespace {

constexpr std::size_t kStlHead = 84;  // with the number of triangles in its last four bytes
constexpr std::size_t kStlTriangle = 50;

std::string_view characters_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void append_utf8(std::uint32_t point, RawVector<std::byte>& bytes) {
  const auto put = [&](std::uint32_t value) { bytes.push_back(static_cast<std::byte>(value)); };
  const auto put_rest = [&](int count) {
    while (count-- > 0) put(0x80 | (point >> 6 * count & 0x3F));
  };
  if (point < 0x80) {
    put(point);
  } else if (point < 0x800) {
    put(0xC0 | point >> 6);
    put_rest(1);
  } else if (point < 0x10000) {
    put(0xE0 | point >> 12);
    put_rest(2);
  } else {
    put(0xF0 | point >> 18);
    put_rest(3);
  }
}

// Zeros behind the last line of such a file are its data.
bool ends_in_binary(std::string_view text, FileFormat format) {
  constexpr std::size_t kHead = 1 << 16;
  const std::string_view head = text.substr(0, kHead);
  const auto has_line = [&](std::string_view start) {
    const std::size_t at = head.find(start);
    return at != std::string_view::npos && at > 0 && (head[at - 1] == '\n' || head[at - 1] == '\r');
  };
  switch (format) {
    case FileFormat::Glb:
    case FileFormat::Gltf:
      return text.starts_with("glTF");
    case FileFormat::Las:
      return true;
    case FileFormat::Stl:  // text has none in the place of the first triangle
      return text.substr(0, std::min(text.find_last_not_of('\0') + 1, kStlHead + kStlTriangle))
                 .find('\0') != std::string_view::npos;
    case FileFormat::Ply:
      return !has_line("format ascii");
    case FileFormat::Pcd:
      return !has_line("DATA ascii");
    case FileFormat::Off:
      return head.find("BINARY") != std::string_view::npos;
    default:
      return false;
  }
}

// A header of no triangles, which ends in zeros as text may.
bool is_bare_stl(std::span<const std::byte> bytes) {
  const std::string_view text = characters_of(bytes);
  return text.size() == kStlHead && text.ends_with(std::string_view("\0\0\0\0", 4)) &&
         !text.starts_with("solid");
}

}  // namespace

bool has_utf8_mark(std::span<const std::byte> bytes) {
  return characters_of(bytes).starts_with(kUtf8Mark);
}

bool is_binary_stl(std::span<const std::byte> bytes) {
  if (bytes.size() < kStlHead) return false;
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kStlHead - sizeof count, sizeof count);
  return count > 0 && bytes.size() == kStlHead + kStlTriangle * count;
}

bool is_utf16(std::span<const std::byte> bytes) {
  if (bytes.size() < 4 || is_binary_stl(bytes)) return false;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned>(bytes[i]); };
  const auto is_letter = [&](std::size_t i) { return byte(i) >= 9 && byte(i) < 127; };
  const bool has_mark =
      (byte(0) == 0xff && byte(1) == 0xfe) || (byte(0) == 0xfe && byte(1) == 0xff);
  const bool has_zeros = (is_letter(0) && is_letter(2) && byte(1) == 0 && byte(3) == 0) ||
                         (is_letter(1) && is_letter(3) && byte(0) == 0 && byte(2) == 0);
  return has_mark || has_zeros;
}

DecodedText decode_utf16(std::span<const std::byte> bytes) {
  const auto byte = [&](std::size_t i) { return std::to_integer<std::uint32_t>(bytes[i]); };
  const bool has_mark = byte(0) >= 0xFE;
  const std::size_t high = byte(0) == 0xFE || byte(0) == 0 ? 0 : 1;
  const auto unit = [&](std::size_t i) { return byte(i + high) << 8 | byte(i + 1 - high); };
  std::size_t end = bytes.size();
  while (end >= 2 && byte(end - 1) == 0 && byte(end - 2) == 0) end -= 2;
  DecodedText text;
  text.bytes.reserve(bytes.size() / 2 + 16);
  std::size_t at = has_mark ? 2 : 0;
  for (; at + 1 < end; at += 2) {
    std::uint32_t point = unit(at);
    // What no text has: control characters, halves of a pair that stand alone.
    if (point < '\t' || (point >= 0xDC00 && point < 0xE000)) break;
    if (point >= 0xD800 && point < 0xDC00) {
      const std::uint32_t low = at + 3 < end ? unit(at + 2) : 0;
      if (low < 0xDC00 || low >= 0xE000) break;
      point = 0x10000 + ((point - 0xD800) << 10) + (low - 0xDC00);
      at += 2;
    }
    append_utf8(point, text.bytes);
  }
  if (at < end) text.damage = at;
  return text;
}

TextFile text_file(const FileBytes& file, FileFormat format) {
  TextFile result{.file = file, .decoded = {}, .warnings = {}};
  if (format == FileFormat::Stl && (is_binary_stl(file.bytes) || is_bare_stl(file.bytes)))
    return result;
  std::span<const std::byte>& bytes = result.file.bytes;
  const std::string name(file.name);
  if (is_utf16(bytes)) {
    const auto fail = [&](const std::string& what) {
      throw Error(ErrorCode::UnreadableInput,
                  formatted("{}: is text of UTF-16{}; save it as UTF-8 (iconv -f UTF-16 -t UTF-8)",
                            name, what));
    };
    if (file.is_strict) fail("");
    DecodedText text = decode_utf16(bytes);
    if (text.damage) fail(formatted(", damaged at byte {}", *text.damage));
    result.decoded = std::move(text.bytes);
    bytes = result.decoded;
    result.warnings.push_back(
        {.code = "utf-16", .message = name + ": is text of UTF-16; it is read as UTF-8"});
  }
  if (has_utf8_mark(bytes)) bytes = bytes.subspan(kUtf8Mark.size());
  const std::size_t size = characters_of(bytes).find_last_not_of('\0') + 1;
  if (size == bytes.size() || size == 0 || file.is_strict ||
      ends_in_binary(characters_of(bytes), format))
    return result;
  const auto behind = static_cast<std::int64_t>(bytes.size() - size);
  result.warnings.push_back(
      {.code = "trailing-zeros",
       .message = formatted("{}: {} behind the text, from byte {} on, {} left out", name,
                            counted(behind, "zero byte"), size, behind == 1 ? "is" : "are"),
       .count = behind});
  bytes = bytes.first(size);
  return result;
}

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

LineRecords::LineRecords(const FileBytes& file, const TextLines& lines, std::size_t part_bytes)
    : start_(lines), parts_(lines.rest().cut(part_bytes)) {
  expect_passes(file, 2);
  first_.resize(parts_.size() + 1, 0);
  std::vector<std::int64_t> line_counts(parts_.size());
  parallel_each(parts_.size(), 1, [&](std::size_t p) {
    TextLines part = parts_[p];
    while (part.next_with_words()) ++first_[p + 1];
    line_counts[p] = part.lines_passed();
    part.count();
  });
  last_line_ = lines.lines_passed();
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    first_[p + 1] += first_[p];
    parts_[p].count_from(last_line_);
    last_line_ += line_counts[p];
  }
}

TextLines LineRecords::before(std::int64_t record) const {
  TextLines lines = start_;
  if (record == 0) return lines;
  const auto behind = std::ranges::lower_bound(first_, record);
  const auto part = static_cast<std::size_t>(behind - first_.begin()) - 1;
  lines.move_before(parts_[part]);
  for (std::int64_t r = first_[part]; r < record; ++r) (void)lines.next_with_words();
  return lines;
}

void LineRecords::fail_at_end(const std::string& what, std::int64_t index,
                              std::int64_t total) const {
  start_.fail_at(std::max<std::int64_t>(last_line_, 1),
                 formatted("the file ends at {} {} of {}", what, index, total), index);
}

std::int64_t FaceParts::append_to(PolygonMesh& mesh) const {
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  std::size_t face_count = 0, corner_count = mesh.face_vertices.size();
  for (const Part& part : parts) {
    for (const std::int32_t size : part.sizes) {
      corner_count += static_cast<std::size_t>(size);
      if (corner_count >= kMost) return static_cast<std::int64_t>(face_count);
      ++face_count;
    }
  }
  mesh.face_offsets.reserve(mesh.face_offsets.size() + face_count);
  mesh.face_vertices.reserve(corner_count);
  for (const Part& part : parts) {
    for (const std::int32_t size : part.sizes)
      mesh.face_offsets.push_back(mesh.face_offsets.back() + size);
    mesh.face_vertices.insert(mesh.face_vertices.end(), part.vertices.begin(), part.vertices.end());
  }
  return -1;
}

}  // namespace planish
