#include "planish/files/read_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/platform/files.h"
#include "planish/core/words.h"
#include "planish/files/readers.h"
#include "planish/files/shared/text_lines.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

namespace fs = std::filesystem;

std::string cannot_read(const std::string& name, const std::error_code& error) {
  return name + ": cannot read: " + error.message();
}

void require_read(const std::string& name, const std::error_code& error) {
  if (error) throw Error(ErrorCode::UnreadableInput, cannot_read(name, error));
}

// What is asked of the machine below that is not worth a question.
constexpr std::uint64_t kAlwaysThere = std::uint64_t{64} << 20;

void require_free(std::uint64_t bytes, const std::string& name) {
  if (bytes <= kAlwaysThere) return;
  const std::uint64_t free = available_memory_bytes();
  if (bytes > free)
    throw Error(ErrorCode::OutOfMemory,
                formatted("{}: {} bytes are to be read, and {} bytes of memory are free; take a "
                          "machine with more, or a smaller file",
                          name, bytes, free));
}

// Fills as much as can be read from the beginning without a gap, on all threads; returns how much.
std::size_t read_pieces(int file, std::span<std::byte> bytes, ReadProgress& progress) {
  constexpr std::size_t kPiece = std::size_t{4} << 20;
  std::vector<std::size_t> filled((bytes.size() + kPiece - 1) / kPiece, 0);
  parallel_each(filled.size(), 1, [&](std::size_t p) {
    const auto piece = bytes.subspan(p * kPiece, std::min(kPiece, bytes.size() - p * kPiece));
    while (filled[p] < piece.size()) {
      std::error_code ignored;  // as the end; who reads on from there meets it again
      const std::size_t got =
          platform::read_at(file, piece.subspan(filled[p]), p * kPiece + filled[p], ignored);
      if (got == 0) break;
      filled[p] += got;
    }
    progress.add(filled[p]);
  });
  std::size_t used = 0;
  for (const std::size_t count : filled) {
    used += count;
    if (count < kPiece) break;
  }
  return used;
}

// So many bytes of a regular file, fewer where it is cut short meanwhile.
RawVector<std::byte> read_regular(int file, std::uint64_t count, const std::string& name,
                                  const Callbacks& callbacks) {
  require_free(count, name);
  RawVector<std::byte> bytes(memory_size(count, name));
  ReadProgress progress(callbacks, bytes.size());
  std::size_t used = read_pieces(file, bytes, progress);
  while (used < bytes.size()) {
    check_stop();
    std::error_code error;
    const std::size_t got = platform::read_at(file, std::span(bytes).subspan(used), used, error);
    require_read(name, error);
    if (got == 0) break;
    used += got;
  }
  bytes.resize(used);
  progress.finish();
  return bytes;
}

// Some devices have no end; more than this comes of none that has.
constexpr std::size_t kMostOfDevice = std::size_t{64} << 20;

bool lies_below(const fs::path& place, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), place.begin(), place.end()).first ==
         folder.end();
}

// An input that is a link has two folders: where it stands, and where it leads to.
bool lies_beside(const fs::path& place, const fs::path& input) {
  std::error_code error;
  const fs::path folder = input.has_parent_path() ? input.parent_path() : fs::path(".");
  const fs::path stands = fs::canonical(folder, error);
  if (!error && lies_below(place, stands)) return true;
  const fs::path leads_to = fs::canonical(input, error);
  return !error && lies_below(place, leads_to.parent_path());
}

// `is_whole`: a longer file than `most` is trouble.
NamedFile read_within(const fs::path& path, const fs::path& input, FileReach reach,
                      std::uint64_t most, bool is_whole) {
  const std::string name = visible(path);
  NamedFile found;
  std::error_code error;
  // Also of what is not there: nobody is told what there is elsewhere.
  fs::path place = fs::absolute(path, error);
  if (!error) place = fs::weakly_canonical(place, error);
  if (error) {
    found.trouble = cannot_read(name, error);
    return found;
  }
  if (reach == FileReach::Beside && !lies_beside(place, input)) {
    found.trouble =
        name + ": leads away from the folder of the file (--textures anywhere follows it there)";
    return found;
  }
  // Opening a pipe would let go on who waits at its other end.
  const fs::file_status kind = fs::status(place, error);
  if (!fs::exists(kind)) {
    found.trouble = cannot_read(
        name, error ? error : std::make_error_code(std::errc::no_such_file_or_directory));
    return found;
  }
  constexpr const char* kOther = ": is a pipe, a device or a folder, where a file is wanted";
  if (!fs::is_regular_file(kind)) {
    found.trouble = name + kOther;
    return found;
  }
  const platform::File file = platform::open_regular_to_read(place, error);
  platform::FileFacts facts;
  if (!error) facts = platform::facts_of(file.number(), error);
  if (error) {
    found.trouble = cannot_read(name, error);
  } else if (facts.kind != platform::FileKind::Regular) {
    found.trouble = name + kOther;
  } else {
    found.size = facts.size;
    if (is_whole && found.size > most) {
      found.trouble =
          formatted("{}: has {} bytes, and no more than {} are read", name, found.size, most);
      return found;
    }
    try {
      found.bytes = read_regular(file.number(), std::min(found.size, most), name, {});
    } catch (const Error& failure) {
      if (failure.code() != ErrorCode::UnreadableInput) throw;
      found.trouble = failure.what();
    }
  }
  return found;
}

}  // namespace

RawVector<std::byte> read_stream(int file, const std::string& name) {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  std::error_code error;
  const platform::FileFacts facts = platform::facts_of(file, error);
  require_read(name, error);
  RawVector<std::byte> bytes(kPiece);
  std::size_t used = 0;
  for (;;) {
    check_stop();
    if (used == bytes.size()) {
      if (facts.kind == platform::FileKind::CharacterDevice && used >= kMostOfDevice)
        throw Error(ErrorCode::UnreadableInput,
                    formatted("{}: is a device, and does not end after {} bytes; name a file, or "
                              "send a pipe",
                              name, kMostOfDevice));
      require_free(2 * static_cast<std::uint64_t>(used), name);
      bytes.resize(2 * bytes.size());
    }
    const std::size_t got = platform::read_some(file, std::span(bytes).subspan(used), error);
    require_read(name, error);
    if (got == 0) break;
    used += got;
  }
  bytes.resize(used);
  return bytes;
}

RawVector<std::byte> read_file(const fs::path& path, const Callbacks& callbacks) {
  const std::string name = visible(path);
  std::error_code error;
  const platform::File file = platform::open_to_read(path, error);
  require_read(name, error);
  const platform::FileFacts facts = platform::facts_of(file.number(), error);
  require_read(name, error);
  if (facts.kind == platform::FileKind::Folder)
    require_read(name, std::make_error_code(std::errc::is_a_directory));
  // Pipes, and files of /proc, say 0 bytes.
  if (facts.kind == platform::FileKind::Regular && facts.size > 0)
    return read_regular(file.number(), facts.size, name, callbacks);
  ReadProgress progress(callbacks, 0);
  RawVector<std::byte> bytes = read_stream(file.number(), name);
  progress.finish();
  return bytes;
}

NamedFile read_named_start(const fs::path& path, const fs::path& input, FileReach reach,
                           std::uint64_t most) {
  return read_within(path, input, reach, most, false);
}

NamedFile read_named(const fs::path& path, const fs::path& input, FileReach reach) {
  return read_within(path, input, reach, kMostNamedBytes, true);
}

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
