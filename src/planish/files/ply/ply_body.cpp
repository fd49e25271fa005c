#include "planish/files/ply/ply_body.h"

#include <algorithm>
#include <optional>

#include "planish/core/formatted.h"
#include "planish/core/stop.h"

namespace planish {

TextLines ply_lines_behind(const FileBytes& file, const PlyHeader& header) {
  FileBytes body = file;
  body.bytes = file.bytes.subspan(header.byte_count);
  TextLines lines(body);
  lines.count_from(header.line_count);
  return lines;
}

namespace {

// An entry has at least one digit and one blank or line end for each of its values.
template <class Place>
void require_text_room(const PlyElement& element, std::size_t bytes_left, const Place& place) {
  const std::size_t least = 2 * std::max<std::size_t>(element.properties.size(), 1);
  if (static_cast<std::uint64_t>(element.count) > (bytes_left + 1) / least)
    place.fail(formatted("header promises {} of element {}, but only {} bytes follow",
                         element.count, quote(element.name), bytes_left),
               -1);
}

}  // namespace

void PlyTextBody::require_room(const PlyElement& element) const {
  const TextLines lines = records_.before(first_);
  require_text_room(element, lines.bytes_left(), lines);
}

void PlyWrappedBody::require_room(const PlyElement& element) const {
  require_text_room(element, cursor_.values_left(PlyType::UInt8), cursor_);
}

void PlyBinaryBody::require_room(const PlyElement& element) const {
  const std::size_t least = std::max<std::size_t>(element.least_bytes(), 1);
  if (static_cast<std::uint64_t>(element.count) > bytes_left() / least)
    fail(
        formatted("header promises {} of element {} of at least {} bytes, but only {} bytes follow",
                  element.count, quote(element.name), least, bytes_left()),
        -1);
}

// The counts of lists say where entries begin. Where one is wrong its piece is the last: whoever
// reads it meets the same.
std::size_t PlyBinaryBody::piece_count(const PlyElement& element) {
  places_.clear();
  bytes_ = 0;
  if (const std::optional<std::size_t> stride = element.fixed_bytes()) {
    for (std::int64_t entry = 0; entry < element.count; entry += kPieceEntries)
      places_.push_back(static_cast<std::size_t>(entry) * *stride);
    bytes_ = static_cast<std::size_t>(element.count) * *stride;
    return places_.size();
  }
  PlyBinaryCursor cursor = cursor_;
  const auto place = [&] { return cursor_.bytes_left() - cursor.bytes_left(); };
  try {
    for (std::int64_t entry = 0; entry < element.count; ++entry) {
      if (entry % kPieceEntries == 0) {
        check_stop();
        places_.push_back(place());
      }
      for (const PlyProperty& property : element.properties)
        skip_ply_value(cursor, property, element, entry);
    }
    bytes_ = place();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;
  }
  return places_.size();
}

}  // namespace planish
