// Based on: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.
#include <algorithm>
#include <array>
#include <limits>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/distributed/obj_attributes.h"
#include "planish/distributed/range_file.h"
#include "planish/distributed/read_slices.h"
#include "planish/files/obj/obj_part.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

namespace {

constexpr std::int64_t kPieceBytes = std::int64_t{64} << 20;
constexpr std::int64_t kPartBytes = std::int64_t{1} << 20;
constexpr std::int64_t kWindowBytes = std::int64_t{1} << 16;
// The readers of parts count in 32 bits.
constexpr std::int64_t kMostVertices = std::numeric_limits<std::int32_t>::max() - 1;

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

// What a rank's range says, with indices that still count from this rank's first vertex.
struct ObjSlice {
  MeshSlice slice;
  std::vector<std::size_t> backward;  // places in face_vertices
  std::int64_t largest_vertex = -1;   // named by a face, from 0
  std::int64_t largest_tag = -1;
  std::int64_t largest_hole = -1;
  std::int64_t first_unknown = std::numeric_limits<std::int64_t>::max();
  std::string largest_place, unknown;
  std::int64_t unknown_count = 0, dropped = 0;
  ObjAttributes attributes;
};

void append_part(ObjPart& part, const ObjTags& tags, const std::string& place, ObjSlice& to) {
  MeshSlice& slice = to.slice;
  to.attributes.append(part, place, slice);
  const auto first_vertex = static_cast<std::int64_t>(slice.positions.size());
  const std::size_t first_corner = slice.face_vertices.size();
  const PolygonMesh& mesh = part.mesh;
  slice.positions.insert(slice.positions.end(), mesh.positions.begin(), mesh.positions.end());
  slice.face_vertices.insert(slice.face_vertices.end(), mesh.face_vertices.begin(),
                             mesh.face_vertices.end());
  for (const std::size_t corner : part.backward_vertices) {
    slice.face_vertices[first_corner + corner] += first_vertex;
    to.backward.push_back(first_corner + corner);
  }
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    slice.face_offsets.push_back(static_cast<std::int64_t>(first_corner) +
                                 mesh.face_offsets[f + 1]);
  for (const CreaseEdge& crease : mesh.creases)
    slice.creases.push_back(
        {crease.v0, crease.v1, crease.sharpness, static_cast<std::int64_t>(slice.creases.size())});
  for (const CornerVertex& corner : mesh.corners)
    slice.corners.push_back(
        {corner.vertex, corner.sharpness, static_cast<std::int64_t>(slice.corners.size())});
  slice.holes.insert(slice.holes.end(), mesh.hole_faces.begin(), mesh.hole_faces.end());
  const auto note = [&](std::int64_t& largest, const LargestIndex& from) {
    if (from.index <= largest) return;
    largest = from.index;
    to.largest_place = place + ":" + std::to_string(from.line);
  };
  note(to.largest_vertex, part.largest_vertex);
  note(to.largest_tag, tags.largest_vertex());
  note(to.largest_hole, tags.largest_face());
  for (const UnknownWord* word :
       std::array<const UnknownWord*, 2>{&part.unknown_keyword, &tags.unknown()}) {
    if (word->count > 0 && to.unknown.empty())
      to.unknown = place + ":" + std::to_string(word->line) + ": " + word->name;
    to.unknown_count += word->count;
  }
  to.dropped += part.dropped_element_count;
}

// The lines of [begin, end), both places where lines begin.
void read_piece(const RangeFile& file, bool has_line_feeds, std::int64_t begin, std::int64_t end,
                ObjSlice& to) {
  RawVector<std::byte> bytes = file.read(begin, end);
  // What TextLines takes for the end of a line is that of the whole file.
  if (has_line_feeds && std::ranges::find(bytes, std::byte{'\n'}) == bytes.end())
    bytes.push_back(std::byte{'\n'});
  const std::string place =
      begin == 0 ? file.path() : file.path() + ", from byte " + std::to_string(begin) + " on";
  const TextLines lines(bytes, place, TextLines::Continuation::Backslash);
  ObjPartReader reader(lines, /*is_first=*/false);
  reader.read();
  append_part(reader.part(), reader.tags(), place, to);
}

void read_range(const RangeFile& file, bool has_line_feeds, std::int64_t begin, std::int64_t end,
                ObjSlice& to) {
  const LineStarts starts(file, has_line_feeds);
  while (begin < end) {
    const std::int64_t next = std::min(starts.at_or_behind(begin + kPartBytes), end);
    read_piece(file, has_line_feeds, begin, next, to);
    if (static_cast<std::int64_t>(to.slice.positions.size()) > kMostVertices)
      throw Error(ErrorCode::UnreadableInput, file.path() + ": more vertices than 32 bits count");
    begin = next;
  }
}

void settle(const Ranks& ranks, const std::string& path, ObjSlice& read) {
  MeshSlice& slice = read.slice;
  slice.vertices = layout_of(ranks, static_cast<std::int64_t>(slice.positions.size()));
  slice.faces = layout_of(ranks, slice.face_count());
  const std::int64_t first = slice.vertices[ranks.rank], total = slice.vertex_total();
  const auto number = [&](auto& tags) {
    const std::int64_t before = sum_before(ranks, static_cast<std::int64_t>(tags.size()));
    for (auto& tag : tags) tag.index += before;
  };
  number(slice.creases);
  number(slice.corners);
  const bool is_obj = total > 0 || sum_over(ranks, read.unknown_count) == 0;
  agree(ranks, [&] {
    const auto fail = [&](const std::string& what) {
      throw Error(ErrorCode::UnreadableInput, what);
    };
    if (!is_obj && !read.unknown.empty())
      fail(read.unknown + " is an unknown word in a file without vertices: this is no OBJ file");
    if (total > kMostVertices)
      fail(path + ": " + std::to_string(total) + " vertices, at most " +
           std::to_string(kMostVertices) + " can be read from OBJ");
    for (const std::size_t corner : read.backward) {
      slice.face_vertices[corner] += first;
      if (slice.face_vertices[corner] < 0)
        fail(path + ": a face counts back behind the first vertex");
    }
    const auto require = [&](std::int64_t largest, int base, const char* what, std::int64_t count) {
      if (largest < count) return;
      fail(read.largest_place + ": " + what + std::to_string(largest + base) + " of " +
           std::to_string(count));
    };
    require(read.largest_vertex, 1, "face names vertex ", total);
    require(read.largest_tag, 0, "tag names vertex ", total);
    require(read.largest_hole, 0, "tag names face ", slice.face_total());
  });
}

void add_warnings(const Ranks& ranks, const ObjSlice& read, std::vector<Warning>& warnings) {
  if (const std::int64_t count = sum_over(ranks, read.unknown_count); count > 0)
    warnings.push_back({.code = "unknown-keyword",
                        .message = std::to_string(count) + " lines of unknown keywords are ignored",
                        .count = count});
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
  ObjSlice read;
  agree(ranks, [&] {
    const LineStarts starts(*file, has_line_feeds);
    const std::int64_t begin = starts.at_or_behind(ranges[ranks.rank]);
    const std::int64_t end =
        ranks.rank + 1 == ranks.size ? file->size() : starts.at_or_behind(ranges[ranks.rank + 1]);
    read_range(*file, has_line_feeds, begin, std::max(begin, end), read);
  });
  settle(ranks, path, read);
  add_warnings(ranks, read, read.slice.warnings);
  read.attributes.settle(ranks, path, read.slice);
  return std::move(read.slice);
}

}  // namespace planish
