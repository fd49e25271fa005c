#include "planish/files/sniff_format.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "planish/core/number_text.h"
#include "planish/files/shared/text_encoding.h"
#include "planish/files/xyz/point_columns.h"

namespace planish {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\f\v";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

std::string_view first_word(std::string_view line) {
  return line.substr(0, line.find_first_of(kBlanks));
}

// The first line that is neither empty nor a comment, of any format; a PCD says what it is in its
// comment.
std::string_view first_line(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    if (line.starts_with("# .PCD")) return line;
    if (!line.empty() && line.front() != '#' && line.front() != '@') return line;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

bool starts_with(std::span<const std::byte> bytes, std::string_view start) {
  return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size())
      .starts_with(start);
}

// OFF and its kin: COFF, NOFF, STOFF, 4OFF...
bool is_off_word(std::string_view word) { return word.size() <= 8 && word.ends_with("OFF"); }

bool is_obj_word(std::string_view word) {
  constexpr std::array<std::string_view, 15> kWords{
      "v", "vt", "vn", "vp", "f", "o", "g", "s", "t", "l", "p", "h", "mtllib", "usemtl", "mg"};
  return std::ranges::find(kWords, word) != kWords.end();
}

// A count alone begins a PTS, two of them a PTX; at least three numbers in a line are a point.
std::optional<FileFormat> numbers_format(std::string_view line, std::string_view second) {
  std::size_t count = 0;
  std::int64_t integer = 0;
  double number = 0;
  const bool is_count = parse_integer(first_word(line), integer);
  while (!line.empty()) {
    const std::size_t end = std::min(line.find_first_of(" \t,;"), line.size());
    if (!parse_number(line.substr(0, end), number)) return std::nullopt;
    ++count;
    line.remove_prefix(end);
    line.remove_prefix(std::min(line.find_first_not_of(" \t,;"), line.size()));
  }
  if (count == 1 && is_count)
    return integer > 0 && parse_integer(second, integer) ? FileFormat::Ptx : FileFormat::Pts;
  return count >= 3 ? std::optional(FileFormat::Xyz) : std::nullopt;
}

}  // namespace

std::optional<FileFormat> sniff_format(std::span<const std::byte> bytes) {
  constexpr std::size_t kLooked = 1 << 16;
  std::span<const std::byte> head = bytes.first(std::min(bytes.size(), kLooked));
  if (starts_with(head, "LASF")) return FileFormat::Las;
  if (is_binary_stl(bytes)) return FileFormat::Stl;
  DecodedText decoded;
  if (is_utf16(head)) {
    decoded = decode_utf16(head);
    head = decoded.bytes;
  }
  std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  if (text.starts_with("glTF")) return FileFormat::Glb;
  if (text.starts_with(kUtf8Mark)) text.remove_prefix(kUtf8Mark.size());
  const std::string_view line = first_line(text);
  if (line.empty()) return std::nullopt;
  const std::string_view word = first_word(line);
  if (word == "ply") return FileFormat::Ply;
  if (line.starts_with("# .PCD") || word == "VERSION" || word == "FIELDS") return FileFormat::Pcd;
  if (word == "solid") return FileFormat::Stl;
  if (line.front() == '{') return FileFormat::Gltf;
  if (is_off_word(word)) return FileFormat::Off;
  if (is_obj_word(word)) return FileFormat::Obj;
  if (!column_names(line).empty()) return FileFormat::Xyz;
  const auto behind = static_cast<std::size_t>(line.data() + line.size() - text.data());
  return numbers_format(line, first_line(text.substr(behind)));
}

std::string_view foreign_content(std::span<const std::byte> bytes) {
  struct Start {
    std::string_view start, what;
  };
  constexpr std::array<Start, 6> kStarts{
      {{"\x1f\x8b", "is compressed by gzip; \"gunzip FILE\" unpacks it"},
       {"PK\x03\x04", "is a ZIP archive; \"unzip FILE\" unpacks it"},
       {"version https://git-lfs",
        "is a pointer of Git LFS, not the file itself; \"git lfs pull\" fetches it"},
       {"<!DOCTYPE html", "is a web page, as of a download that failed; load the file itself"},
       {"<!doctype html", "is a web page, as of a download that failed; load the file itself"},
       {"<html", "is a web page, as of a download that failed; load the file itself"}}};
  const auto found = std::ranges::find_if(
      kStarts, [&](const Start& known) { return starts_with(bytes, known.start); });
  return found == kStarts.end() ? std::string_view() : found->what;
}

}  // namespace planish
