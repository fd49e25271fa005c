#include "planish/files/shared/text_encoding.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "planish/core/counted.h"
#include "planish/core/error.h"

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

}  // namespace planish
