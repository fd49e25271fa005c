#include "planish/distributed/write_cage.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/distributed/mesh_part.h"
#include "planish/doosabin/subdivision.h"
#include "planish/files/shared/attributes.h"
#include "planish/surface/level_one_mesh.h"

namespace planish {
namespace {

// MPI-IO reports faults by what it returns and goes on; a short file would be renamed over a good
// one if that were not looked at.
std::string text_of(int code) {
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(code, text, &length);
  return {text, static_cast<std::size_t>(length)};
}

}  // namespace

StagedFile::StagedFile(const Ranks& ranks, std::string path, bool replaces)
    : ranks_(ranks), path_(std::move(path)) {
  std::string temporary;
  agree(ranks_, [&] {
    if (ranks_.rank == 0) temporary = utf8(output_.emplace(path_, replaces).temporary());
  });
  const RawVector<char> name = all_gather<char>(ranks_, temporary);
  temporary.assign(name.begin(), name.end());
  const int code =
      MPI_File_open(ranks_.comm, temporary.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &file_);
  // Where it is open on some ranks only, nobody can close it: that is left to the job's end.
  agree(ranks_, [&] {
    if (code == MPI_SUCCESS) return;
    file_ = MPI_FILE_NULL;
    fail("cannot be opened by all ranks: " + text_of(code));
  });
}

StagedFile::~StagedFile() {
  if (file_ != MPI_FILE_NULL) (void)MPI_File_close(&file_);
}

void StagedFile::fail(const std::string& what) const {
  throw Error(ErrorCode::UnwritableOutput, path_ + ": " + what);
}

void StagedFile::write(std::int64_t offset, std::span<const std::byte> bytes) {
  const auto own = static_cast<std::int64_t>(bytes.size());
  constexpr auto kRound = static_cast<std::int64_t>(kRoundBytes);
  const std::int64_t rounds = max_over(ranks_, (own + kRound - 1) / kRound);
  std::string fault;
  for (std::int64_t round = 0; round < rounds; ++round) {
    const std::int64_t begin = std::min(round * kRound, own);
    const int count = static_cast<int>(std::min(kRound, own - begin));
    MPI_Status status;
    int written = 0;
    const int code = MPI_File_write_at_all(file_, offset + begin, bytes.data() + begin, count,
                                           MPI_BYTE, &status);
    if (code != MPI_SUCCESS) {
      fault = "cannot be written: " + text_of(code);
    } else if (MPI_Get_count(&status, MPI_BYTE, &written) != MPI_SUCCESS || written != count) {
      fault = formatted("only {} of {} bytes could be written; is the disk full?", written, count);
    }
  }
  agree(ranks_, [&] {
    if (!fault.empty()) fail(fault);
  });
}

void StagedFile::close(std::int64_t bytes) {
  const int synced = MPI_File_sync(file_);
  const int closed = MPI_File_close(&file_);
  file_ = MPI_FILE_NULL;
  agree(ranks_, [&] {
    if (synced != MPI_SUCCESS) fail("cannot be written: " + text_of(synced));
    if (closed != MPI_SUCCESS) fail("cannot be closed: " + text_of(closed));
    if (ranks_.rank != 0) return;
    std::error_code code;
    const std::uintmax_t found = std::filesystem::file_size(output_->temporary(), code);
    if (code) fail("cannot be looked at: " + code.message());
    if (found != static_cast<std::uintmax_t>(bytes))
      fail(formatted("has {} bytes, {} were written; is the disk full?", found, bytes));
  });
}

void StagedFile::commit() {
  agree(ranks_, [&] {
    if (ranks_.rank == 0) output_->commit();
  });
}

namespace {

constexpr std::size_t kShortCount = 255;
static_assert(std::endian::native == std::endian::little, "files are written as memory has them");

template <class Value>
void put(RawVector<std::byte>& bytes, Value value) {
  const auto* from = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), from, from + sizeof(Value));
}

std::string head_of(std::int64_t vertices, std::int64_t face_total, const CageFaces& faces,
                    const std::vector<std::string>& header) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& line : header) text += "comment " + line + "\n";
  text += formatted("element vertex {}\nproperty double x\nproperty double y\nproperty double z\n",
                    vertices);
  if (faces.has_colors)
    text += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  text += formatted("element face {}", face_total);
  text += faces.has_short_counts ? "\nproperty list uchar" : "\nproperty list int";
  return text + " int vertex_indices\nend_header\n";
}

// As the writer of PLY has them.
std::vector<std::array<std::uint8_t, 4>> encoded_colors(std::span<const glm::vec4> colors) {
  std::vector<std::array<std::uint8_t, 4>> encoded;
  encoded.reserve(colors.size());
  for (const glm::vec4& color : colors) {
    const glm::dvec4 share = srgb_of_linear(color);
    std::array<std::uint8_t, 4>& to = encoded.emplace_back();
    for (int k = 0; k < 4; ++k) to[k] = static_cast<std::uint8_t>(std::lround(255 * share[k]));
  }
  return encoded;
}

RawVector<std::byte> vertex_bytes(std::span<const glm::dvec3> positions, const CageFaces& faces) {
  RawVector<std::byte> bytes;
  bytes.reserve(positions.size() * (sizeof(glm::dvec3) + 4));
  for (std::size_t v = 0; v < positions.size(); ++v) {
    put(bytes, positions[v]);
    put(bytes, faces.colors[v]);
  }
  return bytes;
}

}  // namespace

CageFaces encode_faces(const Ranks& ranks, std::span<const std::int64_t> sizes,
                       std::span<const std::int64_t> corners, std::int64_t vertex_total) {
  CageFaces faces;
  std::int64_t largest = 0;
  for (const std::int64_t size : sizes) largest = std::max(largest, size);
  faces.has_short_counts = max_over(ranks, largest) <= static_cast<std::int64_t>(kShortCount);
  agree(ranks, [&] {
    if (vertex_total > std::numeric_limits<std::int32_t>::max())
      throw Error(ErrorCode::InvalidArgument,
                  formatted("--cage: a PLY's int indices end at 2^31 - 1, and the cage has {} "
                            "vertices; leave it out",
                            vertex_total));
    const std::size_t count_bytes = faces.has_short_counts ? 1 : 4;
    faces.bytes.reserve(4 * corners.size() + count_bytes * sizes.size());
    std::size_t corner = 0;
    for (const std::int64_t size : sizes) {
      if (faces.has_short_counts) {
        put(faces.bytes, static_cast<std::uint8_t>(size));
      } else {
        put(faces.bytes, static_cast<std::int32_t>(size));
      }
      for (std::int64_t i = 0; i < size; ++i)
        put(faces.bytes, static_cast<std::int32_t>(corners[corner++]));
    }
  });
  return faces;
}

CageFaces encode_cage_faces(const Ranks& ranks, const MeshSlice& slice) {
  std::vector<std::int64_t> sizes;
  sizes.reserve(static_cast<std::size_t>(slice.face_count()));
  for (std::int64_t f = 0; f < slice.face_count(); ++f)
    sizes.push_back(static_cast<std::int64_t>(slice.face(f).size()));
  CageFaces faces = encode_faces(ranks, sizes, slice.face_vertices, slice.vertex_total());
  faces.has_colors = slice.attributes.has_colors;
  faces.colors = encoded_colors(slice.attributes.colors);
  return faces;
}

void write_cage(const Ranks& ranks, const Layout& vertices, std::int64_t face_total,
                std::span<const glm::dvec3> positions, const CageFaces& faces,
                const std::vector<std::string>& header, StagedFile& file) {
  static_assert(sizeof(glm::dvec3) == 24);
  const std::int64_t vertex_stride = faces.has_colors ? 28 : 24;
  const std::string head = head_of(vertices.back(), face_total, faces, header);
  const auto head_bytes = static_cast<std::int64_t>(head.size());
  file.write(0, ranks.rank == 0 ? std::as_bytes(std::span(head)) : std::span<const std::byte>());
  const RawVector<std::byte> colored =
      faces.has_colors ? vertex_bytes(positions, faces) : RawVector<std::byte>();
  file.write(head_bytes + vertex_stride * vertices[ranks.rank],
             faces.has_colors ? std::span<const std::byte>(colored) : std::as_bytes(positions));
  const auto own = static_cast<std::int64_t>(faces.bytes.size());
  const std::int64_t faces_at = head_bytes + vertex_stride * vertices.back();
  const std::int64_t before = sum_before(ranks, own);
  file.write(faces_at + before, faces.bytes);
  file.close(faces_at + sum_over(ranks, own));
}

std::vector<glm::dvec3> in_file_order(const Ranks& ranks, const Layout& vertices,
                                      std::span<const std::int64_t> file_ids,
                                      std::span<const glm::dvec3> values) {
  struct Placed {
    std::int64_t file_id;
    glm::dvec3 value;
  };
  RawVector<Placed> placed(values.size());
  for (std::size_t v = 0; v < values.size(); ++v) placed[v] = {file_ids[v], values[v]};
  placed = route<Placed>(
      ranks, placed, [&](const Placed& p, std::size_t) { return owner_of(vertices, p.file_id); });
  std::vector<glm::dvec3> ordered(
      static_cast<std::size_t>(vertices[ranks.rank + 1] - vertices[ranks.rank]));
  for (const Placed& p : placed) ordered[p.file_id - vertices[ranks.rank]] = p.value;
  return ordered;
}

namespace {

// Based on: surface/level_one_mesh.cpp, whose vertices are numbered in the order of the file:
// corners, two points on each sharp edge, corner vertices; and whose polygons lie around vertices,
// faces, edges. An edge stands where its first corner does.

// Counts the keys of all ranks in their order.
class DenseNumbers {
 public:
  // Each key once, on any rank.
  DenseNumbers(const Ranks& ranks, std::int64_t key_total, std::span<const std::int64_t> own)
      : ranks_(ranks), layout_(even_layout(key_total, ranks.size)) {
    const auto got = route<std::int64_t>(
        ranks, own, [&](std::int64_t key, std::size_t) { return owner_of(layout_, key); });
    keys_.assign(got.begin(), got.end());
    std::ranges::sort(keys_);
    const std::int64_t count = std::ssize(keys_);
    before_ = sum_before(ranks, count);
    total_ = sum_over(ranks, count);
  }

  [[nodiscard]] std::int64_t total() const { return total_; }
  // Of ascending keys that are among all. All ranks together.
  [[nodiscard]] RawVector<std::int64_t> numbers_of(std::span<const std::int64_t> keys) const {
    return fetch<std::int64_t>(ranks_, keys, layout_, [&](std::int64_t place) {
      const std::int64_t key = layout_[ranks_.rank] + place;
      return before_ + (std::ranges::lower_bound(keys_, key) - keys_.begin());
    });
  }

 private:
  const Ranks& ranks_;
  Layout layout_;
  std::vector<std::int64_t> keys_;  // of this rank's run, ascending
  std::int64_t before_ = 0, total_ = 0;
};

class FairCageMaker {
 public:
  FairCageMaker(const Ranks& ranks, const MeshPart& part, const CornerStarts& corners)
      : ranks_(ranks), part_(part), corners_(corners) {}

  FairCage make(const PartFair& fair, const SharpFeatureOptions& sharp) {
    agree(ranks_, [&] { make_net(fair, sharp); });
    number_state();
    FairCage cage;
    place_points(cage);
    place_polygons(cage);
    return cage;
  }

 private:
  void make_net(const PartFair& fair, const SharpFeatureOptions& sharp) {
    sub_ = SubMeshMaker(part_).make(0, part_.owned_count(), Rings::TwoTagged);
    topology_ = topology_of_sound(sub_.mesh);
    features_ = find_sharp_features(sub_.mesh, *topology_, sub_.mesh.positions, sharp);
    LevelOne level_one;
    level_one.state = fair.state;
    level_one.placement = fair.placement;
    if (sub_.mesh.face_count() == 0) return;  // a rank that owns nothing
    // At the rim a tagged edge may end at another copy of its vertex.
    std::erase_if(sub_.mesh.creases, [&](const CreaseEdge& crease) {
      return topology_->find_edge(crease.v0, crease.v1) < 0;
    });
    net_ = level_one_mesh(sub_.mesh, level_one, sharp, &around_);
  }

  [[nodiscard]] bool is_owned(std::int32_t sub_vertex) const {
    return sub_.vertices[sub_vertex] < part_.owned_count();
  }
  [[nodiscard]] std::int64_t number_of(std::int32_t sub_vertex) const {
    return part_.number_of(sub_.vertices[sub_vertex]);
  }
  [[nodiscard]] bool is_mine(std::int64_t number) const {
    return owner_of(part_.layout, number) == ranks_.rank;
  }
  [[nodiscard]] bool is_my_edge(std::int32_t edge) const {
    const auto [v0, v1] = topology_->edge_vertices(edge);
    return is_mine(std::min(number_of(v0), number_of(v1)));
  }
  [[nodiscard]] bool touches_mine(std::int32_t edge) const {
    const auto [v0, v1] = topology_->edge_vertices(edge);
    return is_owned(v0) || is_owned(v1);
  }
  // Of the corner that an edge leads from, in the file.
  [[nodiscard]] std::int64_t place_of_edge(std::int32_t edge) const {
    return numbers_[topology_->corner_of(edge)];
  }

  // The number in the file of each control point of level 1 that polygons of this rank name.
  void number_state() {
    numbers_.assign(net_.positions.size(), -1);
    const auto starts =
        fetch<std::int64_t>(ranks_, part_.face_ids, corners_.faces,
                            [&](std::int64_t place) { return corners_.starts[place]; });
    for (std::int32_t f = 0; f < part_.face_count(); ++f)
      for (std::int32_t c = part_.face_offsets[f]; c < part_.face_offsets[f + 1]; ++c)
        numbers_[c] = starts[f] + c - part_.face_offsets[f];
    const std::int64_t curves = number_curves();
    const std::int64_t points = number_corners(corners_.total + curves);
    total_ = corners_.total + curves + points;
  }

  std::int64_t number_curves() {
    std::vector<std::int64_t> own, named;
    std::vector<std::int32_t> edges;
    for (std::int32_t e = 0; e < std::ssize(features_.sharp_of_edge); ++e) {
      if (features_.sharp_of_edge[e] < 0 || !touches_mine(e)) continue;
      edges.push_back(e);
      if (is_my_edge(e)) own.push_back(place_of_edge(e));
    }
    // Edges ascend with their first corners, here and in the file.
    for (const std::int32_t edge : edges) named.push_back(place_of_edge(edge));
    const DenseNumbers sharp(ranks_, corners_.total, own);
    const auto numbers = sharp.numbers_of(named);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const std::int32_t point = topology_->corner_count() + 2 * features_.sharp_of_edge[edges[i]];
      numbers_[point] = corners_.total + 2 * numbers[i];
      numbers_[point + 1] = numbers_[point] + 1;
    }
    return 2 * sharp.total();
  }

  std::int64_t number_corners(std::int64_t before) {
    std::vector<std::int64_t> own;
    std::vector<std::int32_t> points;
    const std::int32_t first = topology_->corner_count() + 2 * features_.sharp_edge_count;
    for (std::int32_t c = 0; c < features_.corner_count; ++c) {
      const std::int32_t vertex = features_.corner_vertices[c];
      if (!is_owned(vertex)) continue;
      own.push_back(part_.file_ids[sub_.vertices[vertex]]);
      points.push_back(first + c);
    }
    const DenseNumbers corners(ranks_, vertex_total(), own);
    // A sub mesh has its vertices in the order of the file.
    const auto numbers = corners.numbers_of(own);
    for (std::size_t i = 0; i < points.size(); ++i) numbers_[points[i]] = before + numbers[i];
    return corners.total();
  }

  // Each point by the owner of its vertex.
  void place_points(FairCage& cage) const {
    std::vector<std::int64_t> ids;
    std::vector<glm::dvec3> points;
    const auto add = [&](std::int32_t point, std::int32_t vertex) {
      if (!is_owned(vertex)) return;
      ids.push_back(numbers_[point]);
      points.push_back(net_.positions[point]);
    };
    for (std::int32_t c = 0; c < topology_->corner_count(); ++c) add(c, sub_.mesh.face_vertices[c]);
    for (std::int32_t e = 0; e < std::ssize(features_.sharp_of_edge); ++e) {
      if (features_.sharp_of_edge[e] < 0) continue;
      const std::int32_t point = topology_->corner_count() + 2 * features_.sharp_of_edge[e];
      const auto [v0, v1] = topology_->edge_vertices(e);
      add(point, v0);
      add(point + 1, v1);
    }
    const std::int32_t first = topology_->corner_count() + 2 * features_.sharp_edge_count;
    for (std::int32_t c = 0; c < features_.corner_count; ++c)
      add(first + c, features_.corner_vertices[c]);
    cage.vertices = even_layout(total_, ranks_.size);
    cage.positions = in_file_order(ranks_, cage.vertices, ids, points);
  }

  // Where the polygons around an element stand among all; -1: another rank has them.
  [[nodiscard]] std::int64_t place_of_ring(std::int32_t ring) const {
    const std::int32_t vertices = sub_.mesh.vertex_count(), faces = sub_.mesh.face_count();
    if (ring < vertices) return is_owned(ring) ? part_.file_ids[sub_.vertices[ring]] : -1;
    if (ring < vertices + faces) {
      const std::int32_t face = ring - vertices;
      std::int64_t first = number_of(sub_.mesh.face(face).front());
      for (const std::int32_t v : sub_.mesh.face(face)) first = std::min(first, number_of(v));
      return is_mine(first) ? vertex_total() + part_.face_ids[sub_.faces[face]] : -1;
    }
    const std::int32_t edge = ring - vertices - faces;
    return is_my_edge(edge) ? vertex_total() + face_total() + place_of_edge(edge) : -1;
  }

  void place_polygons(FairCage& cage) const {
    const Layout layout = even_layout(vertex_total() + face_total() + corners_.total, ranks_.size);
    // Place, size, corners; place, size, ...
    std::vector<std::pair<std::int64_t, std::int32_t>> own;
    for (std::int32_t f = 0; f < net_.face_count(); ++f)
      if (const std::int64_t place = place_of_ring(around_[f]); place >= 0)
        own.emplace_back(place, f);
    std::ranges::stable_sort(own, {}, &std::pair<std::int64_t, std::int32_t>::first);
    std::vector<std::int64_t> stream, counts(static_cast<std::size_t>(ranks_.size), 0);
    for (const auto& [place, face] : own) {
      const auto named = net_.face(face);
      counts[owner_of(layout, place)] += 2 + std::ssize(named);
      stream.insert(stream.end(), {place, std::ssize(named)});
      for (const std::int32_t point : named) stream.push_back(numbers_[point]);
    }
    const auto got = all_to_all<std::int64_t>(ranks_, stream, counts);
    std::vector<std::size_t> begins;
    for (std::size_t at = 0; at < got.size(); at += 2 + got[at + 1]) begins.push_back(at);
    // All polygons around an element come from one rank, in their order.
    std::ranges::stable_sort(begins, {}, [&](std::size_t at) { return got[at]; });
    std::vector<std::int64_t> sizes, corners;
    for (const std::size_t at : begins) {
      sizes.push_back(got[at + 1]);
      corners.insert(corners.end(), got.begin() + at + 2, got.begin() + at + 2 + got[at + 1]);
    }
    cage.face_total = sum_over(ranks_, std::ssize(sizes));
    cage.faces = encode_faces(ranks_, sizes, corners, total_);
  }

  [[nodiscard]] std::int64_t vertex_total() const { return part_.layout.back(); }
  [[nodiscard]] std::int64_t face_total() const { return corners_.faces.back(); }

  const Ranks& ranks_;
  const MeshPart& part_;
  const CornerStarts& corners_;
  SubMesh sub_;
  std::shared_ptr<const MeshTopology> topology_;
  SharpFeatures features_;
  PolygonMesh net_;
  std::vector<std::int32_t> around_;   // of each polygon of the net: its ring
  std::vector<std::int64_t> numbers_;  // of each point of the net: that in the file; -1: not named
  std::int64_t total_ = 0;             // points of all ranks
};

}  // namespace

CornerStarts corner_starts_of(const Ranks& ranks, const MeshSlice& slice) {
  const std::int64_t holes = sum_over(ranks, std::ssize(slice.holes));
  if (holes > 0)
    throw AgreedError(ErrorCode::InvalidArgument,
                      formatted("--cage: ranks write no cage of a fair surface with holes, and {} "
                                "faces are tagged so; leave it out, or take planish on one machine",
                                holes));
  CornerStarts corners;
  corners.faces = slice.faces;
  const auto own = static_cast<std::int64_t>(slice.face_vertices.size());
  corners.total = sum_over(ranks, own);
  const std::int64_t before = sum_before(ranks, own);
  corners.starts.assign(slice.face_offsets.begin(), slice.face_offsets.end() - 1);
  for (std::int64_t& start : corners.starts) start += before;
  return corners;
}

FairCage make_fair_cage(const Ranks& ranks, const MeshPart& part, const PartFair& fair,
                        const CornerStarts& corners, const SharpFeatureOptions& sharp) {
  return FairCageMaker(ranks, part, corners).make(fair, sharp);
}

}  // namespace planish
