#include "planish/distributed/read_slices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/files/obj/read_obj.h"
#include "planish/files/ply/read_ply.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/shared/text_lines.h"

namespace planish {
namespace {

// From rank 0; `counts` are its own.
template <class T>
std::vector<T> scattered(const Ranks& ranks, std::span<const T> values,
                         std::span<const std::int64_t> counts) {
  const std::vector<std::int64_t> none(static_cast<std::size_t>(ranks.size), 0);
  const auto own =
      ranks.rank == 0 ? all_to_all<T>(ranks, values, counts) : all_to_all<T>(ranks, {}, none);
  return {own.begin(), own.end()};
}

}  // namespace

std::vector<std::string> texts_of_all(const Ranks& ranks, std::span<const std::string> own) {
  std::vector<std::int64_t> own_sizes;
  std::string own_letters;
  for (const std::string& text : own) {
    own_sizes.push_back(static_cast<std::int64_t>(text.size()));
    own_letters += text;
  }
  const auto sizes = all_gather<std::int64_t>(ranks, own_sizes);
  const auto letters = all_gather<char>(ranks, own_letters);
  std::vector<std::string> texts;
  std::size_t at = 0;
  for (const std::int64_t size : sizes) {
    texts.emplace_back(letters.data() + at, static_cast<std::size_t>(size));
    at += static_cast<std::size_t>(size);
  }
  return texts;
}

void settle_groups(const Ranks& ranks, std::span<const FaceGroup> own,
                   std::vector<std::int32_t> face_groups, SliceAttributes& attributes) {
  std::vector<std::string> names;
  for (const FaceGroup& group : own) {
    names.push_back(group.name);
    names.push_back(group.material);
  }
  const std::vector<std::string> all = texts_of_all(ranks, names);
  GroupList list;
  bool any_named = false;
  for (std::size_t i = 0; i < all.size(); i += 2) {
    any_named |= !all[i].empty() || !all[i + 1].empty();
    list.index_of({.name = all[i], .material = all[i + 1]});
  }
  attributes.has_groups = any_named;
  if (!any_named) return;
  for (std::int32_t& group : face_groups) group = list.index_of(own[group]);
  attributes.groups = list.take();
  attributes.face_groups = std::move(face_groups);
}

SliceAttributes scatter_attributes(const Ranks& ranks, const PolygonMesh& mesh,
                                   const ScatterCounts& counts) {
  SliceAttributes attributes;
  std::int64_t known[4] = {!mesh.colors.empty(), !mesh.face_uvs.empty(), !mesh.face_groups.empty(),
                           static_cast<std::int64_t>(mesh.uvs.size())};
  MPI_Bcast(known, 4, MPI_INT64_T, 0, ranks.comm);
  attributes.has_colors = known[0] != 0;
  attributes.has_uvs = known[1] != 0;
  attributes.has_groups = known[2] != 0;
  if (attributes.has_colors)
    attributes.colors = scattered<glm::vec4>(ranks, mesh.colors, counts.vertices);
  if (attributes.has_uvs) {
    attributes.uv_runs = even_layout(known[3], ranks.size);
    std::vector<std::int64_t> uv_counts;
    uv_counts.reserve(static_cast<std::size_t>(ranks.size));
    for (int r = 0; r < ranks.size; ++r)
      uv_counts.push_back(attributes.uv_runs[r + 1] - attributes.uv_runs[r]);
    attributes.uvs = scattered<glm::dvec2>(ranks, mesh.uvs, uv_counts);
    const std::vector<std::int32_t> named =
        scattered<std::int32_t>(ranks, mesh.face_uvs, counts.corners);
    attributes.face_uvs.assign(named.begin(), named.end());
  }
  if (!attributes.has_groups) return attributes;
  std::vector<std::string> names;
  if (ranks.rank == 0) {
    for (const FaceGroup& group : mesh.groups) {
      names.push_back(group.name);
      names.push_back(group.material);
    }
  }
  const std::vector<std::string> all = texts_of_all(ranks, names);
  for (std::size_t i = 0; i < all.size(); i += 2)
    attributes.groups.push_back({.name = all[i], .material = all[i + 1]});
  attributes.face_groups = scattered<std::int32_t>(ranks, mesh.face_groups, counts.faces);
  return attributes;
}

namespace {

void require_vertex(std::int32_t vertex, const char* key, std::int64_t total) {
  if (vertex >= 0 && vertex < total) return;
  throw Error(
      ErrorCode::UnusableMesh,
      formatted("{} names vertex {} of {}; vertices are counted from 0", key, vertex, total));
}

}  // namespace

void add_tags(const Ranks& ranks, std::span<const CreaseEdge> creases,
              std::span<const CornerVertex> corners, MeshSlice& slice) {
  agree(ranks, [&] {
    for (const CreaseEdge& crease : creases)
      for (const std::int32_t vertex : {crease.v0, crease.v1})
        require_vertex(vertex, "crease_edges", slice.vertex_total());
    for (const CornerVertex& corner : corners)
      require_vertex(corner.vertex, "corner_vertices", slice.vertex_total());
  });
  std::int64_t next_crease = sum_over(ranks, std::ssize(slice.creases));
  std::int64_t next_corner = sum_over(ranks, std::ssize(slice.corners));
  if (ranks.rank != 0) return;
  for (const CreaseEdge& crease : creases)
    slice.creases.push_back({crease.v0, crease.v1, crease.sharpness, next_crease++});
  for (const CornerVertex& corner : corners)
    slice.corners.push_back({corner.vertex, corner.sharpness, next_corner++});
}

void clear_tags(MeshSlice& slice) {
  slice.creases.clear();
  slice.corners.clear();
}

RangeFile::RangeFile(std::string path) : path_(std::move(path)) {
  std::error_code error;
  file_ = platform::open_to_read(path_, error);
  platform::FileFacts facts;
  if (!error) facts = platform::facts_of(file_.number(), error);
  if (error) throw Error(ErrorCode::UnreadableInput, path_ + ": " + error.message());
  if (facts.kind != platform::FileKind::Regular)
    throw Error(ErrorCode::UnreadableInput,
                path_ + ": is no regular file, of which ranges can be read");
  size_ = static_cast<std::int64_t>(facts.size);
}

RawVector<std::byte> RangeFile::read(std::int64_t begin, std::int64_t end) const {
  constexpr std::size_t kPieceBytes = std::size_t{64} << 20;
  begin = std::clamp<std::int64_t>(begin, 0, size_);
  end = std::clamp<std::int64_t>(end, begin, size_);
  RawVector<std::byte> bytes(static_cast<std::size_t>(end - begin));
  for (std::size_t done = 0; done < bytes.size();) {
    std::error_code error;
    const std::size_t got = platform::read_at(
        file_.number(), std::span(bytes).subspan(done, std::min(bytes.size() - done, kPieceBytes)),
        static_cast<std::uint64_t>(begin) + done, error);
    if (error) throw Error(ErrorCode::UnreadableInput, path_ + ": " + error.message());
    if (got == 0)
      throw Error(ErrorCode::UnreadableInput,
                  formatted("{}: became shorter while it was read, at byte {}", path_,
                            begin + static_cast<std::int64_t>(done)));
    done += got;
  }
  return bytes;
}

RecordChains::RecordChains(std::int64_t range_bytes, std::int64_t candidates, const Next& next)
    : range_bytes_(range_bytes), chains_(static_cast<std::size_t>(candidates)) {
  std::map<std::int64_t, std::int32_t> heads;  // place -> the chain that is there
  for (std::int64_t c = 0; c < candidates; ++c) heads.emplace(c, static_cast<std::int32_t>(c));
  while (!heads.empty() && heads.begin()->first < range_bytes) {
    std::int64_t place = heads.begin()->first;
    const std::int32_t chain = heads.begin()->second;
    heads.erase(heads.begin());
    const std::int64_t stop =
        heads.empty() ? range_bytes : std::min(range_bytes, heads.begin()->first);
    // The rearmost chain runs until it is no longer that.
    do {
      place = next(place);
    } while (place >= 0 && place < stop);
    if (place < 0) continue;
    const auto [other, is_new] = heads.emplace(place, chain);
    if (!is_new) chains_[chain].joined = other->second;
  }
  for (const auto& [place, chain] : heads) chains_[chain].end = place;
}

std::int64_t RecordChains::overhang(std::int64_t start) const {
  if (start < 0) return -1;
  if (start >= range_bytes_) return start - range_bytes_;  // a record longer than the range
  if (start >= static_cast<std::int64_t>(chains_.size())) return -1;
  auto chain = static_cast<std::size_t>(start);
  while (chains_[chain].joined >= 0) chain = static_cast<std::size_t>(chains_[chain].joined);
  return chains_[chain].end < 0 ? -1 : chains_[chain].end - range_bytes_;
}

namespace {

// Based on: G. Turk, "The PLY Polygon File Format", 1994.

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

namespace {

// "=" and the name, or nothing.
std::array<std::string, 3> texts_of(const ObjNames& names) {
  const auto text = [](const std::optional<std::string>& name) {
    return name ? "=" + *name : std::string();
  };
  return {text(names.object), text(names.group), text(names.material)};
}

void take_texts(std::span<const std::string> texts, ObjNames& names) {
  std::optional<std::string>* const to[] = {&names.object, &names.group, &names.material};
  for (std::size_t i = 0; i < texts.size(); ++i)
    if (!texts[i].empty()) *to[i] = texts[i].substr(1);
}

void settle_colors(const Ranks& ranks, std::vector<glm::vec4> colors, MeshSlice& slice) {
  SliceAttributes& to = slice.attributes;
  to.has_colors = max_over(ranks, std::int64_t{!colors.empty()}) > 0;
  if (!to.has_colors) return;
  to.colors = std::move(colors);
  to.colors.resize(slice.positions.size(), kNoObjColor);
  std::ranges::replace(to.colors, kNoObjColor, glm::vec4(1.0f));
}

void settle_uvs(const Ranks& ranks, ObjPart& part, MeshSlice& slice) {
  SliceAttributes& to = slice.attributes;
  to.uv_runs = layout_of(ranks, static_cast<std::int64_t>(part.uvs.size()));
  to.has_uvs = max_over(ranks, std::int64_t{!part.mesh.face_uvs.empty()}) > 0;
  // Coordinates that no corner names are dropped.
  if (!to.has_uvs) return;
  to.uvs = std::move(part.uvs);
  to.face_uvs.assign(part.mesh.face_uvs.begin(), part.mesh.face_uvs.end());
  to.face_uvs.resize(slice.face_vertices.size(), -1);
}

void settle_names(const Ranks& ranks, const std::vector<ObjPart::Naming>& namings,
                  MeshSlice& slice) {
  ObjNames own;
  for (const ObjPart::Naming& naming : namings) own.take(naming);
  const auto texts = texts_of(own);
  const std::vector<std::string> all = texts_of_all(ranks, texts);
  ObjNames names;
  for (int r = 0; r < ranks.rank; ++r)
    take_texts(std::span(all).subspan(static_cast<std::size_t>(r) * texts.size(), texts.size()),
               names);
  GroupList list;
  std::vector<std::int32_t> face_groups;
  const auto name_until = [&](std::int64_t face) {
    if (face > static_cast<std::int64_t>(face_groups.size()))
      face_groups.resize(static_cast<std::size_t>(face), list.index_of(names.face_group()));
  };
  for (const ObjPart::Naming& naming : namings) {
    name_until(naming.faces_before);
    names.take(naming);
  }
  name_until(slice.face_count());
  settle_groups(ranks, list.groups(), std::move(face_groups), slice.attributes);
}

// Gives the slice, whose runs are known, what rides on the vertices, corners and faces of this
// rank's range of an OBJ file, all ranks together: colours of vertices that have none, texture
// coordinates, groups that go on from the ranks before. Takes it from `part`.
void settle_obj_attributes(const Ranks& ranks, ObjPart& part, MeshSlice& slice) {
  settle_colors(ranks, std::move(part.mesh.colors), slice);
  settle_uvs(ranks, part, slice);
  settle_names(ranks, part.namings, slice);
}

// Based on: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.

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

namespace {

constexpr std::int64_t kHeaderBytes = 65536;

FileFormat format_for(const std::string& path, std::optional<FileFormat> given) {
  const std::optional<FileFormat> format = given ? given : format_of(path);
  if (!format)
    throw Error(ErrorCode::InvalidArgument, path + ": no format has that extension; " +
                                                names_of(FormatUse::ReadMesh) + " can be read");
  if (!serves(*format, FormatUse::ReadMesh))
    throw Error(ErrorCode::InvalidArgument,
                path +
                    ": points cannot be read over several ranks; make a mesh of them with "
                    "planish reconstruct");
  return *format;
}

void require_small(const std::string& path, FileFormat format) {
  const RangeFile file(path);
  if (file.size() <= kMostWholeBytes) return;
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: {} bytes of {} can only be read by one rank, at most 2 GiB; save it "
                        "as binary little-endian PLY or as OBJ",
                        path, file.size(), name_of(format)));
}

MeshSlice read_by_first_rank(const Ranks& ranks, const std::string& path, FileFormat format) {
  MeshFile file;
  agree(ranks, [&] {
    if (ranks.rank != 0) return;
    require_small(path, format);
    file = read_mesh(path, {.format = format, .is_strict = true});
  });
  MeshSlice slice = scatter_mesh(ranks, file.mesh);
  slice.warnings = std::move(file.warnings);  // rank 0 alone reports them
  return slice;
}

// Face sizes, then corners, each rank's in a run.
void scatter_faces(const Ranks& ranks, const PolygonMesh& mesh,
                   std::span<const std::int64_t> vertex_counts, MeshSlice& slice) {
  std::vector<std::int64_t> size_counts(ranks.size, 0), corner_counts(ranks.size, 0);
  RawVector<std::int64_t> sizes, corners;
  if (ranks.rank == 0) {
    for (int r = 0; r < ranks.size; ++r) {
      size_counts[r] = slice.faces[r + 1] - slice.faces[r];
      corner_counts[r] = mesh.face_offsets[slice.faces[r + 1]] - mesh.face_offsets[slice.faces[r]];
    }
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) sizes.push_back(mesh.face_size(f));
    corners.assign(mesh.face_vertices.begin(), mesh.face_vertices.end());
  }
  for (const std::int64_t size : all_to_all<std::int64_t>(ranks, sizes, size_counts))
    slice.face_offsets.push_back(slice.face_offsets.back() + size);
  const auto named = all_to_all<std::int64_t>(ranks, corners, corner_counts);
  slice.face_vertices.assign(named.begin(), named.end());
  slice.attributes = scatter_attributes(ranks, mesh, {vertex_counts, size_counts, corner_counts});
}

}  // namespace

MeshSlice scatter_mesh(const Ranks& ranks, const PolygonMesh& mesh) {
  MeshSlice slice;
  std::int64_t totals[2] = {mesh.vertex_count(), mesh.face_count()};
  MPI_Bcast(totals, 2, MPI_INT64_T, 0, ranks.comm);
  slice.vertices = even_layout(totals[0], ranks.size);
  slice.faces = even_layout(totals[1], ranks.size);
  std::vector<std::int64_t> counts(ranks.size, 0);
  std::span<const glm::dvec3> positions;
  if (ranks.rank == 0) {
    for (int r = 0; r < ranks.size; ++r) counts[r] = slice.vertices[r + 1] - slice.vertices[r];
    positions = mesh.positions;
    for (std::size_t i = 0; i < mesh.creases.size(); ++i)
      slice.creases.push_back({mesh.creases[i].v0, mesh.creases[i].v1, mesh.creases[i].sharpness,
                               static_cast<std::int64_t>(i)});
    for (std::size_t i = 0; i < mesh.corners.size(); ++i)
      slice.corners.push_back(
          {mesh.corners[i].vertex, mesh.corners[i].sharpness, static_cast<std::int64_t>(i)});
    slice.holes.assign(mesh.hole_faces.begin(), mesh.hole_faces.end());
  }
  const auto own = all_to_all<glm::dvec3>(ranks, positions, counts);
  slice.positions.assign(own.begin(), own.end());
  scatter_faces(ranks, mesh, counts, slice);
  return slice;
}

MeshSlice read_slices(const Ranks& ranks, const std::string& path,
                      std::optional<FileFormat> given) {
  FileFormat format{};
  PlyHeader header;
  bool is_plain = true;
  agree(ranks, [&] {
    format = format_for(path, given);
    const RangeFile file(path);
    // Text that has to be told from its beginning on is read whole, by rank 0.
    const auto start = file.read(0, 4);
    is_plain = !is_utf16(start) && !has_utf8_mark(start);
    if (format != FileFormat::Ply || !is_plain) return;
    const auto bytes = file.read(0, kHeaderBytes);
    try {
      header = read_ply_header({.bytes = bytes, .name = path, .path = {}, .is_strict = true});
    } catch (const Error&) {
      // A longer header is read whole, by rank 0.
      if (file.size() <= kHeaderBytes) throw;
    }
  });
  if (!is_plain) return read_by_first_rank(ranks, path, format);
  if (format == FileFormat::Obj) return read_obj_slices(ranks, path);
  if (format == FileFormat::Ply && has_sliceable_body(header))
    return read_ply_slices(ranks, path, header);
  return read_by_first_rank(ranks, path, format);
}

}  // namespace planish
