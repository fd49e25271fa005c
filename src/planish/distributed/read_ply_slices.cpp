// Based on: G. Turk, "The PLY Polygon File Format", 1994.
#include <algorithm>
#include <bit>
#include <vector>

#include "planish/core/formatted.h"
#include "planish/distributed/range_file.h"
#include "planish/distributed/read_slices.h"
#include "planish/distributed/record_chains.h"
#include "planish/files/ply/ply_vertex.h"
#include "planish/files/shared/srgb.h"

namespace planish {

namespace {

// A face of more corners cannot be refined, and what a record may be bounds what has to be tried.
constexpr std::int64_t kMostCorners = 65535;

bool is_integer(PlyType type) { return type != PlyType::Float32 && type != PlyType::Float64; }

std::int64_t integer_at(std::span<const std::byte> bytes, PlyType type) {
  return static_cast<std::int64_t>(ply_number(bytes, type, std::endian::little));
}

[[noreturn]] void fail(const std::string& path, const std::string& what,
                       std::int64_t element = Error::kNoElement) {
  throw Error(ErrorCode::UnreadableInput, path + ": " + what, element);
}

// Of the record of a face: bytes before the list, its types, bytes behind it.
struct FaceRecord {
  std::int64_t before = 0, after = 0;
  PlyType count_type{}, index_type{};
  std::int64_t vertex_total = 0;

  explicit FaceRecord(const PlyElement& element, std::int64_t vertices) : vertex_total(vertices) {
    const PlyProperty* list = ply_vertex_list(element);
    count_type = *list->count_type;
    index_type = list->type;
    for (const PlyProperty& property : element.properties) {
      if (&property == list) continue;
      const auto bytes = static_cast<std::int64_t>(byte_count_of(property.type));
      (&property < list ? before : after) += bytes;
    }
  }
  [[nodiscard]] std::int64_t count_bytes() const {
    return static_cast<std::int64_t>(byte_count_of(count_type));
  }
  [[nodiscard]] std::int64_t index_bytes() const {
    return static_cast<std::int64_t>(byte_count_of(index_type));
  }
  [[nodiscard]] std::int64_t most_bytes() const {
    const std::int64_t most = count_bytes() == 1 ? 255 : kMostCorners;
    return before + count_bytes() + most * index_bytes() + after;
  }
  [[nodiscard]] std::int64_t size_at(std::span<const std::byte> bytes, std::int64_t place) const {
    return integer_at(bytes.subspan(place + before), count_type);
  }
  [[nodiscard]] std::int64_t index_at(std::span<const std::byte> bytes, std::int64_t place,
                                      std::int64_t corner) const {
    return integer_at(bytes.subspan(place + before + count_bytes() + corner * index_bytes()),
                      index_type);
  }
  // Behind the record; -1 where none can be.
  [[nodiscard]] std::int64_t next(std::span<const std::byte> bytes, std::int64_t place) const {
    const auto end = static_cast<std::int64_t>(bytes.size());
    if (place + before + count_bytes() > end) return -1;
    const std::int64_t size = size_at(bytes, place);
    if (size < 1 || size > kMostCorners) return -1;
    const std::int64_t behind = place + before + count_bytes() + size * index_bytes() + after;
    if (behind > end) return -1;
    for (std::int64_t k = 0; k < size; ++k) {
      const std::int64_t index = index_at(bytes, place, k);
      if (index < 0 || index >= vertex_total) return -1;
    }
    return behind;
  }
  // Why next() gave -1.
  [[nodiscard]] std::string fault(std::span<const std::byte> bytes, std::int64_t place) const {
    const auto end = static_cast<std::int64_t>(bytes.size());
    if (place + before + count_bytes() > end) return "the file ends inside it";
    const std::int64_t size = size_at(bytes, place);
    if (size < 1 || size > kMostCorners)
      return formatted("a list of {} corners, 1 to {} are possible", size, kMostCorners);
    for (std::int64_t k = 0; k < size; ++k) {
      const std::int64_t behind = place + before + count_bytes() + (k + 1) * index_bytes();
      if (behind > end) return "the file ends inside it";
      const std::int64_t index = index_at(bytes, place, k);
      if (index < 0 || index >= vertex_total)
        return formatted("it names vertex {} of {}", index, vertex_total);
    }
    return "the file ends inside it";
  }
};

const PlyElement* element_named(const PlyHeader& header, std::string_view name) {
  const auto found = std::ranges::find(header.elements, name, &PlyElement::name);
  return found == header.elements.end() ? nullptr : &*found;
}

// Without lists.
std::int64_t fixed_bytes_of(const PlyElement& element) {
  return static_cast<std::int64_t>(element.least_bytes());
}

// The vertices [first, last) with their texture coordinates and colours.
void read_vertices(const RangeFile& file, const PlyElement& element, std::int64_t body,
                   std::int64_t first, std::int64_t last, MeshSlice& slice) {
  const PlyVertexLayout layout = ply_vertex_layout(element);
  if (layout.missing_axis != 0)
    fail(file.path(),
         std::string("element `vertex` has no property `") + layout.missing_axis + "`");
  const std::int64_t stride = fixed_bytes_of(element);
  const RawVector<std::byte> bytes = file.read(body + first * stride, body + last * stride);
  const auto count = static_cast<std::size_t>(last - first);
  SliceAttributes& attributes = slice.attributes;
  slice.positions.resize(count);
  attributes.uvs.resize(layout.has_uvs ? count : 0);
  attributes.colors.resize(layout.has_colors ? count : 0);
  PlyBinaryCursor cursor({.bytes = bytes, .name = file.path(), .path = {}, .is_strict = true},
                         {.format = PlyFormat::LittleEndian});
  PlyNotes notes;
  for (std::int64_t v = first; v < last; ++v) {
    const PlyVertex vertex = read_ply_vertex(cursor, element, layout, v, notes);
    const std::int64_t i = v - first;
    slice.positions[i] = vertex.position();
    if (layout.has_uvs) attributes.uvs[i] = vertex.uv();
    if (layout.has_colors) attributes.colors[i] = vertex.color();
  }
  std::vector<Warning> none;  // integers are within their range
  settle_colors(attributes.colors, file.path(), /*whole_is_usual=*/false, none);
}

// Each rank tells the next where its first record begins.
std::int64_t start_from_rank_before(const Ranks& ranks, const RecordChains& chains,
                                    std::int64_t& overhang) {
  constexpr int kTag = 7;
  std::int64_t start = 0;
  if (ranks.rank > 0)
    MPI_Recv(&start, 1, MPI_INT64_T, ranks.rank - 1, kTag, ranks.comm, MPI_STATUS_IGNORE);
  overhang = chains.overhang(start);
  if (ranks.rank + 1 < ranks.size)
    MPI_Send(&overhang, 1, MPI_INT64_T, ranks.rank + 1, kTag, ranks.comm);
  return start;
}

class FaceRange {
 public:
  FaceRange(const Ranks& ranks, const RangeFile& file, const FaceRecord& record, std::int64_t begin)
      : ranks_(ranks), file_(file), record_(record) {
    const Layout layout = even_layout(std::max<std::int64_t>(file.size() - begin, 0), ranks.size);
    begin_ = begin + layout[ranks.rank];
    range_bytes_ = layout[ranks.rank + 1] - layout[ranks.rank];
  }

  // All ranks together.
  void read(MeshSlice& slice) {
    RawVector<std::byte> bytes;
    agree(ranks_,
          [&] { bytes = file_.read(begin_, begin_ + range_bytes_ + record_.most_bytes()); });
    const std::int64_t candidates = ranks_.rank == 0 ? std::min<std::int64_t>(1, range_bytes_)
                                                     : std::min(record_.most_bytes(), range_bytes_);
    const RecordChains chains(range_bytes_, candidates,
                              [&](std::int64_t place) { return record_.next(bytes, place); });
    std::int64_t overhang = 0;
    const std::int64_t start = start_from_rank_before(ranks_, chains, overhang);
    agree(ranks_, [&] {
      // The rank whose range has the fault names it; those behind have no beginning.
      if (start >= 0) take_faces(bytes, start, slice);
    });
  }

 private:
  void take_faces(std::span<const std::byte> bytes, std::int64_t start, MeshSlice& slice) const {
    std::int64_t place = start;
    while (place < range_bytes_) {
      const std::int64_t next = record_.next(bytes, place);
      if (next < 0)
        fail(file_.path(),
             formatted("the face at byte {}: {}", begin_ + place, record_.fault(bytes, place)));
      const std::int64_t size = record_.size_at(bytes, place);
      for (std::int64_t k = 0; k < size; ++k)
        slice.face_vertices.push_back(record_.index_at(bytes, place, k));
      slice.face_offsets.push_back(static_cast<std::int64_t>(slice.face_vertices.size()));
      place = next;
    }
  }

  const Ranks& ranks_;
  const RangeFile& file_;
  const FaceRecord& record_;
  std::int64_t begin_ = 0, range_bytes_ = 0;
};

}  // namespace

bool has_sliceable_body(const PlyHeader& header) {
  if (header.format != PlyFormat::LittleEndian || header.elements.size() != 2) return false;
  const PlyElement &vertex = header.elements[0], &face = header.elements[1];
  if (vertex.name != "vertex" || face.name != "face" || ply_vertex_list(face) == nullptr)
    return false;
  const auto is_list = [](const PlyProperty& p) { return p.count_type.has_value(); };
  // What colours as floating-point numbers go up to only the whole file tells.
  const PlyVertexLayout layout = ply_vertex_layout(vertex);
  for (std::size_t i = 0; i < vertex.properties.size(); ++i)
    if (layout.slots[i] >= 5 && layout.slots[i] <= 8 && !is_integer(vertex.properties[i].type))
      return false;
  return std::ranges::none_of(vertex.properties, is_list) &&
         std::ranges::count_if(face.properties, is_list) == 1 &&
         is_integer(ply_vertex_list(face)->type);
}

MeshSlice read_ply_slices(const Ranks& ranks, const std::string& path, const PlyHeader& header) {
  MeshSlice slice;
  std::optional<RangeFile> file;
  const PlyElement &vertex = *element_named(header, "vertex"),
                   &face = *element_named(header, "face");
  const auto body = static_cast<std::int64_t>(header.byte_count);
  const std::int64_t stride = std::max<std::int64_t>(fixed_bytes_of(vertex), 1);
  agree(ranks, [&] {
    file.emplace(path);
    if (vertex.count > (file->size() - body) / stride)
      fail(path, formatted("header promises {} of element `vertex` of at least {} bytes, but only "
                           "{} bytes follow",
                           vertex.count, stride, file->size() - body));
    slice.vertices = even_layout(vertex.count, ranks.size);
    read_vertices(*file, vertex, body, slice.vertices[ranks.rank], slice.vertices[ranks.rank + 1],
                  slice);
  });
  const FaceRecord record(face, vertex.count);
  FaceRange(ranks, *file, record, body + vertex.count * stride).read(slice);
  slice.faces = layout_of(ranks, slice.face_count());
  agree(ranks, [&] {
    if (slice.face_total() != face.count)
      fail(path, formatted("header promises {} of element `face`, but {} follow", face.count,
                           slice.face_total()));
  });
  const PlyVertexLayout layout = ply_vertex_layout(vertex);
  slice.attributes.has_colors = layout.has_colors;
  slice.attributes.has_uvs = layout.has_uvs;
  if (layout.has_uvs) {
    slice.attributes.uv_runs = slice.vertices;
    slice.attributes.face_uvs = slice.face_vertices;
  }
  return slice;
}

}  // namespace planish
