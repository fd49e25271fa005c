// Based on: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.
#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planish/core/number_text.h"
#include "planish/distributed/obj_attributes.h"
#include "planish/distributed/range_file.h"
#include "planish/distributed/read_slices.h"
#include "planish/files/obj/obj_parts.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

namespace {

constexpr std::int64_t kPieceBytes = std::int64_t{64} << 20;
constexpr std::int64_t kPartBytes = std::int64_t{1} << 20;
constexpr std::int64_t kWindowBytes = std::int64_t{1} << 16;

bool holds_line_feed(const RangeFile& file, std::int64_t begin, std::int64_t end) {
  for (; begin < end; begin += kPieceBytes) {
    const auto bytes = file.read(begin, std::min(begin + kPieceBytes, end));
    if (std::ranges::find(bytes, std::byte{'\n'}) != bytes.end()) return true;
  }
  return false;
}

// Lines as TextLines has them, but of a file of which only windows are read.
class LineStarts {
 public:
  LineStarts(const RangeFile& file, bool has_line_feeds)
      : file_(file), end_of_line_{has_line_feeds ? '\n' : '\r'} {}

  // The first place at or behind `from` where a line begins that does not continue another; the
  // file's end if there is none.
  [[nodiscard]] std::int64_t at_or_behind(std::int64_t from) const {
    if (from <= 0) return 0;
    for (std::int64_t begin = from - 1; begin < file_.size(); begin += kWindowBytes) {
      // Two bytes before the window tell whether its first line end continues.
      const std::int64_t read_from = std::max<std::int64_t>(begin - 2, 0);
      const auto bytes = file_.read(read_from, begin + kWindowBytes);
      for (auto i = static_cast<std::size_t>(begin - read_from); i < bytes.size(); ++i)
        if (bytes[i] == std::byte(end_of_line_) && !continues(bytes, i))
          return read_from + static_cast<std::int64_t>(i) + 1;
    }
    return file_.size();
  }

 private:
  static bool continues(std::span<const std::byte> bytes, std::size_t end) {
    const std::size_t last = end > 0 && bytes[end - 1] == std::byte{'\r'} ? end - 1 : end;
    return last > 0 && bytes[last - 1] == std::byte{'\\'};
  }

  const RangeFile& file_;
  char end_of_line_;
};

// Where the parts of [begin, end) begin, and its end; both are places where lines begin.
std::vector<std::int64_t> part_places(const RangeFile& file, bool has_line_feeds,
                                      std::int64_t begin, std::int64_t end) {
  const LineStarts starts(file, has_line_feeds);
  std::vector<std::int64_t> places{begin};
  do {
    places.push_back(std::min(starts.at_or_behind(places.back() + kPartBytes), end));
  } while (places.back() < end);
  return places;
}

// Calls use() with the lines of [begin, end).
void use_lines(const RangeFile& file, bool has_line_feeds, std::int64_t begin, std::int64_t end,
               const std::function<void(const TextLines&)>& use) {
  RawVector<std::byte> bytes = file.read(begin, end);
  // What TextLines takes for the end of a line is that of the whole file.
  if (has_line_feeds && std::ranges::find(bytes, std::byte{'\n'}) == bytes.end())
    bytes.push_back(std::byte{'\n'});
  const FileBytes text{.bytes = bytes, .name = file.path(), .path = {}, .is_strict = true};
  use(TextLines(text, TextLines::Continuation::Backslash));
}

// What stands before this rank's range, and in the whole file.
struct Standing {
  ObjCounts before, all;
};

Standing standing_of(const Ranks& ranks, const ObjCounts& own) {
  Standing standing;
  // Corners are counted by each rank for itself.
  for (const auto count :
       {&ObjCounts::line, &ObjCounts::vertex, &ObjCounts::uv, &ObjCounts::face}) {
    standing.before.*count = sum_before(ranks, own.*count);
    standing.all.*count = sum_over(ranks, own.*count);
  }
  return standing;
}

// The same on all ranks: how often, and where first in the file.
LineNote over_ranks(const Ranks& ranks, const LineNote& own) {
  LineNote all;
  all.count = sum_over(ranks, own.count);
  if (all.count == 0) return all;
  const std::array<std::string, 2> texts{own.what, std::to_string(own.line)};
  const std::vector<std::string> of_all = texts_of_all(ranks, texts);
  for (std::size_t i = 0; i < of_all.size() && all.what.empty(); i += 2) {
    all.what = of_all[i];
    (void)parse_integer(of_all[i + 1], all.line);
  }
  return all;
}

MeshSlice slice_of(const Ranks& ranks, const RangeFile& file, ObjPart& part,
                   const Standing& standing) {
  part.notes.unknown_keyword = over_ranks(ranks, part.notes.unknown_keyword);
  part.tags.unknown = over_ranks(ranks, part.tags.unknown);
  part.notes.clamped_colors = sum_over(ranks, part.notes.clamped_colors);
  agree(ranks, [&] {
    const FileBytes nothing{.bytes = {}, .name = file.path(), .path = {}, .is_strict = true};
    require_obj(part, standing.all, TextLines(nothing));
  });
  MeshSlice slice;
  warn_of(part, file.path(), slice.warnings);
  PolygonMesh& mesh = part.mesh;
  slice.positions = std::move(mesh.positions);
  slice.face_vertices.assign(mesh.face_vertices.begin(), mesh.face_vertices.end());
  slice.face_offsets.assign(mesh.face_offsets.begin(), mesh.face_offsets.end());
  slice.vertices = layout_of(ranks, std::ssize(slice.positions));
  slice.faces = layout_of(ranks, slice.face_count());
  std::int64_t index = sum_before(ranks, std::ssize(mesh.creases));
  for (const CreaseEdge& crease : mesh.creases)
    slice.creases.push_back({crease.v0, crease.v1, crease.sharpness, index++});
  index = sum_before(ranks, std::ssize(mesh.corners));
  for (const CornerVertex& corner : mesh.corners)
    slice.corners.push_back({corner.vertex, corner.sharpness, index++});
  slice.holes.assign(mesh.hole_faces.begin(), mesh.hole_faces.end());
  settle_obj_attributes(ranks, part, slice);
  return slice;
}

}  // namespace

MeshSlice read_obj_slices(const Ranks& ranks, const std::string& path) {
  std::optional<RangeFile> file;
  Layout ranges;
  bool has_line_feeds = false;
  agree(ranks, [&] {
    file.emplace(path);
    ranges = even_layout(file->size(), ranks.size);
    // Files without one in their beginning are rare: those are looked through.
    has_line_feeds = holds_line_feed(*file, 0, std::min(file->size(), kWindowBytes)) ||
                     holds_line_feed(*file, ranges[ranks.rank], ranges[ranks.rank + 1]);
  });
  has_line_feeds = max_over(ranks, std::int64_t{has_line_feeds}) > 0;
  std::vector<std::int64_t> places;
  std::optional<ObjParts> parts;
  agree(ranks, [&] {
    const LineStarts starts(*file, has_line_feeds);
    const std::int64_t begin = starts.at_or_behind(ranges[ranks.rank]);
    const std::int64_t end =
        ranks.rank + 1 == ranks.size ? file->size() : starts.at_or_behind(ranges[ranks.rank + 1]);
    places = part_places(*file, has_line_feeds, begin, std::max(begin, end));
    parts.emplace(
        places.size() - 1,
        [&](std::size_t p, const std::function<void(const TextLines&)>& use) {
          use_lines(*file, has_line_feeds, places[p], places[p + 1], use);
        },
        /*is_start=*/ranks.rank == 0);
  });
  const Standing standing = standing_of(ranks, parts->counts());
  ObjPart part;
  agree(ranks, [&] { part = parts->join(standing.before); });
  parts.reset();
  return slice_of(ranks, *file, part, standing);
}

}  // namespace planish
