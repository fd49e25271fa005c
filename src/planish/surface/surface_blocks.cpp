#include "planish/surface/surface_blocks.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>

#include "planish/core/callbacks.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/core/words.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/surface/kept_rows.h"
#include "planish/surface/level_faces.h"
#include "planish/surface/mesh_blocks.h"

namespace planish {
namespace {

// Calls body(piece) for all pieces on all threads; step "evaluate" goes from `from` to `to`.
template <class Body>
void for_pieces(std::span<const RowRange> pieces, const Callbacks& callbacks, double from,
                double to, const Body& body) {
  LoopProgress progress(callbacks, "evaluate", from, to, static_cast<std::int64_t>(pieces.size()));
  parallel_each(pieces.size(), 1, [&](std::size_t i) {
    body(pieces[i]);
    progress.add();
  });
}

// Rows and faces of a piece: those of several tiles, still within a core's cache.
constexpr std::int64_t kPieceRows = 1 << 14;

// Also of faces whose rows are made along.
constexpr std::int64_t kPieceFaces = 1 << 13;

template <class T>
std::span<T> part_of(RawVector<T>& values, std::int64_t first, std::int64_t count) {
  return std::span(values).subspan(static_cast<std::size_t>(first),
                                   static_cast<std::size_t>(count));
}

}  // namespace

void SurfaceBlocks::cuts(RowRange faces, std::span<std::uint8_t> from_1) const {
  RawVector<glm::dvec3> positions(static_cast<std::size_t>(4 * faces.count));
  RawVector<glm::vec3> normals(positions.size());
  corners(faces, positions, normals);
  for (std::size_t f = 0; f < from_1.size(); ++f) {
    const glm::dvec3* p = positions.data() + 4 * f;
    from_1[f] = is_cut_from_1(p[0], p[1], p[2], p[3]) ? 1 : 0;
  }
}

// By runs of rows that follow one another.
DegenerateRows SurfaceBlocks::rows_at(std::span<const std::int32_t> rows,
                                      const RowTarget& target) const {
  DegenerateRows found;
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t count = 1;
    while (i + count < rows.size() && rows[i + count] == rows[i + count - 1] + 1) ++count;
    RowTarget run;
    run.origin = target.origin;
    const auto take = [&](const auto& all, auto& part) {
      if (!all.empty()) part = all.subspan(i, count);
    };
    take(target.positions, run.positions);
    take(target.stored, run.stored);
    take(target.normals, run.normals);
    take(target.colors, run.colors);
    found.add(this->rows({rows[i], static_cast<std::int64_t>(count)}, run));
    i += count;
  }
  return found;
}

std::vector<RowRange> ranges_of(std::int64_t count, std::int64_t size) {
  std::vector<RowRange> ranges;
  for (std::int64_t first = 0; first < count; first += size) {
    ranges.push_back({first, std::min(size, count - first)});
  }
  return ranges;
}

std::vector<RowRange> sorted(std::vector<RowRange> ranges) {
  std::sort(ranges.begin(), ranges.end(),
            [](const RowRange& a, const RowRange& b) { return a.first < b.first; });
  return ranges;
}

void warn_of(const DegenerateRows& rows, const Callbacks& callbacks) {
  if (rows.count == 0) return;
  callbacks.warn(
      {"degenerate-normals",
       counted(rows.count, "vertex") +
           (rows.count == 1 ? " has parallel tangents; its normal is that of the facets"
                            : " have parallel tangents; their normals are those of the facets"),
       rows.count, rows.first});
}

DegenerateRows make_all_rows(const SurfaceBlocks& blocks, const RowTarget& all,
                             const Callbacks& callbacks) {
  DegenerateRows degenerate;
  std::mutex mutex;
  const auto add = [&](const DegenerateRows& found) {
    if (found.count == 0) return;
    const std::lock_guard lock(mutex);
    degenerate.add(found);
  };
  const bool by_faces = blocks.makes_face_rows() && all.stored.empty() && all.colors.empty();
  const RowRange along = by_faces ? blocks.rows_of_faces() : RowRange{0, 0};
  if (by_faces) {
    for_pieces(ranges_of(blocks.info().face_count, kPieceFaces), callbacks, 0, 0.75,
               [&](RowRange faces) { add(blocks.face_rows(faces, all)); });
  }
  std::vector<RowRange> pieces = blocks.row_blocks(kPieceRows);
  std::erase_if(pieces, [&](const RowRange& piece) {
    return piece.first >= along.first && piece.first + piece.count <= along.first + along.count;
  });
  for_pieces(pieces, callbacks, by_faces ? 0.75 : 0, 0.8, [&](RowRange rows) {
    RowTarget target = all;
    const auto take = [&](auto& values) {
      if (!values.empty())
        values = values.subspan(static_cast<std::size_t>(rows.first),
                                static_cast<std::size_t>(rows.count));
    };
    take(target.positions);
    take(target.stored);
    take(target.normals);
    take(target.colors);
    add(blocks.rows(rows, target));
  });
  return degenerate;
}

VertexAttribute all_rows(const SurfaceBlocks& blocks, std::size_t attribute) {
  const auto& info = blocks.info().attributes[attribute];
  const int width = info.width;
  VertexAttribute made =
      attribute_of_size(info.name, width, static_cast<std::size_t>(blocks.info().row_count));
  const std::vector<RowRange> ranges = ranges_of(blocks.info().row_count, kPieceRows);
  parallel_each(ranges.size(), 1, [&](std::size_t i) {
    blocks.attribute(attribute, ranges[i],
                     std::span(made.values)
                         .subspan(static_cast<std::size_t>(width * ranges[i].first),
                                  static_cast<std::size_t>(width * ranges[i].count)));
  });
  return made;
}

SurfaceMesh collect(const SurfaceBlocks& blocks, const Callbacks& callbacks) {
  const HostScope host(callbacks);
  const SurfaceInfo& info = blocks.info();
  SurfaceMesh surface;
  surface.level = info.level;
  surface.base_vertices = info.base_vertices;
  surface.groups = info.groups;
  surface.face_offsets = info.face_offsets;
  const auto row_count = static_cast<std::size_t>(info.row_count);
  surface.positions.resize(row_count);
  surface.normals.resize(row_count);
  if (info.has_colors) surface.colors.resize(row_count);
  RowTarget all;
  all.positions = surface.positions;
  all.normals = surface.normals;
  all.colors = surface.colors;
  const DegenerateRows degenerate = make_all_rows(blocks, all, callbacks);
  for (std::size_t k = 0; k < info.attributes.size(); ++k)
    surface.attributes.push_back(all_rows(blocks, k));

  surface.face_vertices.resize(static_cast<std::size_t>(info.corner_count));
  if (info.uv_count > 0) surface.face_uvs.resize(surface.face_vertices.size());
  if (info.has_groups) surface.face_groups.resize(static_cast<std::size_t>(info.face_count));
  for_pieces(ranges_of(info.face_count, kPieceRows), callbacks, 0.8, 1, [&](RowRange faces) {
    const std::int64_t first = info.first_corner(faces.first);
    const std::int64_t count = info.first_corner(faces.first + faces.count) - first;
    blocks.face_vertices(faces, part_of(surface.face_vertices, first, count));
    if (info.uv_count > 0) blocks.face_uvs(faces, part_of(surface.face_uvs, first, count));
    if (info.has_groups) {
      blocks.face_groups(faces, part_of(surface.face_groups, faces.first, faces.count));
    }
  });
  surface.uvs.resize(static_cast<std::size_t>(info.uv_count));
  for_pieces(ranges_of(info.uv_count, kPieceRows), {}, 0, 0,
             [&](RowRange uvs) { blocks.uvs(uvs, part_of(surface.uvs, uvs.first, uvs.count)); });
  warn_of(degenerate, callbacks);
  callbacks.report("evaluate", 1);
  return surface;
}

MeshBlocks::MeshBlocks(const SurfaceMesh& surface) : surface_(surface) {
  info_.level = surface.level;
  info_.row_count = static_cast<std::int64_t>(surface.positions.size());
  info_.face_count = surface.face_count();
  info_.corner_count = static_cast<std::int64_t>(surface.face_vertices.size());
  info_.uv_count = static_cast<std::int64_t>(surface.uvs.size());
  info_.has_colors = !surface.colors.empty();
  info_.has_groups = !surface.face_groups.empty();
  for (const VertexAttribute& attribute : surface.attributes)
    info_.attributes.push_back({attribute.name, attribute.width});
  info_.groups = surface.groups;
  info_.base_vertices = surface.base_vertices;
  info_.face_offsets = surface.face_offsets;
}

MeshBlocks::MeshBlocks(const SurfaceMesh& surface, const PolygonMesh& mesh) : MeshBlocks(surface) {
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    if (is_hole[face]) continue;
    mesh_faces_.push_back(face);
    const std::int64_t last = ends_.empty() ? 0 : ends_.back();
    ends_.push_back(last + descendant_count(surface, mesh.face_size(face)));
  }
}

MeshBlocks::MeshBlocks(const SurfaceMesh& surface, std::span<const std::int32_t> mesh_faces)
    : MeshBlocks(surface) {
  given_faces_ = mesh_faces;
}

DegenerateRows MeshBlocks::rows(RowRange rows, const RowTarget& target) const {
  copy(surface_.positions, rows, target.positions);
  copy(surface_.normals, rows, target.normals);
  copy(surface_.colors, rows, target.colors);
  for (std::size_t i = 0; i < target.stored.size(); ++i) {
    target.stored[i] = glm::vec3(surface_.positions[rows.first + i] - target.origin);
  }
  return {};  // whoever made the surface has told
}

void MeshBlocks::attribute(std::size_t index, RowRange rows, std::span<float> values) const {
  const VertexAttribute& from = surface_.attributes[index];
  std::copy_n(from.values.begin() + from.width * rows.first, from.width * rows.count,
              values.begin());
}

void MeshBlocks::ancestors(RowRange faces, std::span<std::int32_t> mesh_faces) const {
  if (!given_faces_.empty()) return copy(given_faces_, faces, mesh_faces);
  auto at = std::upper_bound(ends_.begin(), ends_.end(), faces.first) - ends_.begin();
  for (std::int64_t i = 0; i < faces.count; ++i) {
    while (ends_[at] <= faces.first + i) ++at;
    mesh_faces[i] = mesh_faces_[at];
  }
}

void MeshBlocks::corners(RowRange faces, std::span<glm::dvec3> positions,
                         std::span<glm::vec3> normals) const {
  const RowRange range = corner_range(faces);
  for (std::int64_t i = 0; i < range.count; ++i) {
    const std::int32_t row = surface_.face_vertices[range.first + i];
    positions[i] = surface_.positions[row];
    normals[i] = surface_.normals[row];
  }
}

std::unique_ptr<SurfaceBlocks> blocks_of(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  return std::make_unique<MeshBlocks>(surface, mesh);
}

namespace {

constexpr std::int64_t kSweptFaces = 1 << 11;
constexpr std::int64_t kKeptRows = 1 << 14;

// Values of all rows in pieces that fit into what a job has freed before: one large array would
// take fresh pages, which cost more than the rows.
template <class Vector>
class RowPieces {
 public:
  void resize(std::int64_t count) {
    for (std::int64_t first = 0; first < count; first += kPiece) {
      pieces_.emplace_back(static_cast<std::size_t>(std::min(kPiece, count - first)));
      places_.push_back(pieces_.back().data());
    }
  }
  [[nodiscard]] bool empty() const { return pieces_.empty(); }
  [[nodiscard]] std::span<Vector* const> places() const { return places_; }
  [[nodiscard]] const Vector& operator[](std::int64_t row) const {
    return places_[row / kPiece][row % kPiece];
  }
  void put(std::int64_t first, std::span<const Vector> values) {
    for_parts(first, values.size(), [&](Vector* place, std::size_t at, std::size_t count) {
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(at), count, place);
    });
  }
  void get(std::int64_t first, std::span<Vector> values) const {
    for_parts(first, values.size(), [&](const Vector* place, std::size_t at, std::size_t count) {
      std::copy_n(place, count, values.begin() + static_cast<std::ptrdiff_t>(at));
    });
  }

 private:
  static constexpr std::int64_t kPiece = FaceRows::kPieceRows;

  template <class Part>
  void for_parts(std::int64_t row, std::size_t count, const Part& part) const {
    for (std::size_t at = 0; at < count;) {
      const auto size = std::min(static_cast<std::size_t>(kPiece - row % kPiece), count - at);
      part(places_[row / kPiece] + row % kPiece, at, size);
      at += size;
      row += static_cast<std::int64_t>(size);
    }
  }

  std::vector<RawVector<Vector>> pieces_;
  std::vector<Vector*> places_;
};

class KeptRows final : public SurfaceBlocks {
 public:
  KeptRows(const SurfaceBlocks& surface, const KeepOptions& options)
      : surface_(surface), origin_(options.origin) {
    const HostScope host(options.callbacks);
    info_ = surface.info();
    // Few rows name each other's from all over: their doubles serve as corners too.
    const std::int64_t count = info_.row_count;
    const auto fits = [&](std::size_t bytes) {
      return static_cast<std::uint64_t>(count) * bytes <= options.row_bytes;
    };
    keeps_doubles_ = info_.level <= 1 && fits(sizeof(glm::dvec3) + sizeof(glm::vec3));
    keeps_rows_ = keeps_doubles_ || fits(2 * sizeof(glm::vec3));
    if (keeps_rows_) normals_.resize(count);
    if (keeps_doubles_) positions_.resize(count);
    if (keeps_rows_ && !keeps_doubles_) stored_.resize(count);
    if (keeps_rows_) make_rows(options.callbacks);
    if (info_.corners_per_face == 4 && info_.face_offsets.empty()) sweep(options);
    warn_of(degenerate_, options.callbacks);
    options.callbacks.report("evaluate", 1);
  }

  [[nodiscard]] std::vector<RowRange> row_blocks(std::int64_t row_count) const override {
    return surface_.row_blocks(row_count);
  }
  DegenerateRows rows(RowRange range, const RowTarget& target) const override;
  DegenerateRows rows_at(std::span<const std::int32_t> rows,
                         const RowTarget& target) const override {
    const bool is_kept = keeps_rows_ && target.colors.empty() &&
                         (keeps_doubles_ || (target.positions.empty() &&
                                             (target.stored.empty() || target.origin == origin_)));
    if (is_kept) return SurfaceBlocks::rows_at(rows, target);
    const DegenerateRows found = surface_.rows_at(rows, target);
    return keeps_rows_ ? DegenerateRows{} : found;
  }
  bool kept_rows_at(std::span<const std::int32_t> rows, const glm::dvec3& origin,
                    std::span<glm::vec3> stored, std::span<glm::vec3> normals) const override {
    if (!keeps_doubles_ && (!keeps_rows_ || origin != origin_)) return false;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      stored[i] = keeps_doubles_ ? glm::vec3(positions_[rows[i]] - origin) : stored_[rows[i]];
      normals[i] = normals_[rows[i]];
    }
    return true;
  }
  void face_vertices(RowRange faces, std::span<std::int32_t> rows) const override {
    surface_.face_vertices(faces, rows);
  }
  void face_uvs(RowRange faces, std::span<std::int32_t> uvs) const override {
    surface_.face_uvs(faces, uvs);
  }
  void face_groups(RowRange faces, std::span<std::int32_t> groups) const override {
    surface_.face_groups(faces, groups);
  }
  void ancestors(RowRange faces, std::span<std::int32_t> mesh_faces) const override {
    surface_.ancestors(faces, mesh_faces);
  }
  void uvs(RowRange uvs, std::span<glm::dvec2> values) const override { surface_.uvs(uvs, values); }
  void attribute(std::size_t index, RowRange rows, std::span<float> values) const override {
    surface_.attribute(index, rows, values);
  }
  bool uvs_of(std::span<const glm::dvec2> given, std::span<glm::dvec2> values) const override {
    return surface_.uvs_of(given, values);
  }
  bool corners_of(std::span<const glm::vec4> given, std::span<glm::vec4> values) const override {
    return surface_.corners_of(given, values);
  }
  bool rows_of(std::span<const glm::vec4> given, std::span<glm::vec4> values) const override {
    return surface_.rows_of(given, values);
  }
  void corners(RowRange faces, std::span<glm::dvec3> positions,
               std::span<glm::vec3> normals) const override;
  void cuts(RowRange faces, std::span<std::uint8_t> from_1) const override {
    if (cuts_.empty()) return SurfaceBlocks::cuts(faces, from_1);
    std::copy_n(cuts_.begin() + faces.first, faces.count, from_1.begin());
  }

 private:
  void make_rows(const Callbacks& callbacks);
  void sweep(const KeepOptions& options);
  void add(const DegenerateRows& rows) {
    if (rows.count == 0) return;
    const std::lock_guard lock(mutex_);
    degenerate_.add(rows);
  }

  const SurfaceBlocks& surface_;
  glm::dvec3 origin_;
  bool keeps_rows_ = false, keeps_doubles_ = false;
  RowPieces<glm::dvec3> positions_;
  RowPieces<glm::vec3> stored_, normals_;
  RawVector<std::uint8_t> cuts_;
  std::mutex mutex_;
  DegenerateRows degenerate_;
};

// Those that the sweep does not make.
void KeptRows::make_rows(const Callbacks& callbacks) {
  const RowRange swept = keeps_doubles_ ? RowRange{0, 0} : surface_.rows_of_faces();
  std::vector<RowRange> pieces = surface_.row_blocks(kKeptRows);
  std::erase_if(pieces, [&](const RowRange& piece) {
    return piece.first >= swept.first && piece.first + piece.count <= swept.first + swept.count;
  });
  for_pieces(pieces, callbacks, 0, 0.3, [&](const RowRange& piece) {
    thread_local RawVector<glm::dvec3> positions;
    thread_local RawVector<glm::vec3> stored, normals;
    const auto count = static_cast<std::size_t>(piece.count);
    RowTarget target;
    target.origin = origin_;
    normals.resize(count);
    target.normals = normals;
    if (keeps_doubles_) {
      positions.resize(count);
      target.positions = positions;
    } else {
      stored.resize(count);
      target.stored = stored;
    }
    add(surface_.rows(piece, target));
    normals_.put(piece.first, target.normals);
    if (keeps_doubles_) positions_.put(piece.first, target.positions);
    if (!keeps_doubles_) stored_.put(piece.first, target.stored);
  });
}

void KeptRows::sweep(const KeepOptions& options) {
  RawVector<std::uint8_t> cuts(static_cast<std::size_t>(info_.face_count));
  const std::vector<RowRange> pieces = swept_pieces(info_);
  FaceRows along;
  along.origin = origin_;
  along.stored = stored_.places();
  along.normals = normals_.places();
  for_pieces(pieces, options.callbacks, 0.3, 1, [&](const RowRange& faces) {
    thread_local RawVector<glm::dvec3> positions;
    thread_local RawVector<glm::vec3> normals;
    positions.resize(static_cast<std::size_t>(4 * faces.count));
    normals.resize(positions.size());
    if (keeps_doubles_) {
      corners(faces, positions, normals);
    } else {
      const DegenerateRows found = surface_.corners_and_rows(faces, positions, normals, along);
      if (keeps_rows_) add(found);
    }
    for (std::int64_t f = 0; f < faces.count; ++f) {
      const glm::dvec3* p = positions.data() + 4 * f;
      cuts[faces.first + f] = is_cut_from_1(p[0], p[1], p[2], p[3]) ? 1 : 0;
    }
    if (options.visit) options.visit(faces, positions, normals);
  });
  cuts_ = std::move(cuts);
}

DegenerateRows KeptRows::rows(RowRange range, const RowTarget& target) const {
  RowTarget left = target;
  const auto copy = [&](const auto& from, auto& to) {
    if (from.empty() || to.empty()) return;
    from.get(range.first, to);
    to = {};
  };
  copy(positions_, left.positions);
  copy(normals_, left.normals);
  if (target.origin == origin_) copy(stored_, left.stored);
  if (keeps_doubles_ && !left.stored.empty()) {
    for (std::int64_t i = 0; i < range.count; ++i) {
      left.stored[i] = glm::vec3(positions_[range.first + i] - target.origin);
    }
    left.stored = {};
  }
  if (!left.positions.empty() || !left.stored.empty() || !left.normals.empty() ||
      !left.colors.empty()) {
    const DegenerateRows found = surface_.rows(range, left);
    if (!keeps_rows_) return found;
  }
  return {};  // told when they were made
}

void KeptRows::corners(RowRange faces, std::span<glm::dvec3> positions,
                       std::span<glm::vec3> normals) const {
  if (!keeps_doubles_) return surface_.corners(faces, positions, normals);
  thread_local RawVector<std::int32_t> rows;
  rows.resize(positions.size());
  surface_.face_vertices(faces, rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    positions[i] = positions_[rows[i]];
    normals[i] = normals_[rows[i]];
  }
}

}  // namespace

std::vector<RowRange> swept_pieces(const SurfaceInfo& info) {
  // At high levels so many that the patches of a piece still fill vectors.
  return ranges_of(info.face_count, kSweptFaces << std::max(info.level - 3, 0));
}

std::unique_ptr<SurfaceBlocks> keep_rows(const SurfaceBlocks& surface, const KeepOptions& options) {
  return std::make_unique<KeptRows>(surface, options);
}

namespace {

constexpr std::int64_t kMarkedFaces = std::int64_t{1} << 14;
constexpr std::int32_t kWordBits = 64;

// of(range, place) for numbers that follow one another, from that place of `wanted` on.
template <class Of>
void for_runs(std::span<const std::int32_t> wanted, const Of& of) {
  for (std::size_t i = 0; i < wanted.size();) {
    std::size_t count = 1;
    while (i + count < wanted.size() && wanted[i + count] == wanted[i + count - 1] + 1) ++count;
    of(RowRange{wanted[i], static_cast<std::int64_t>(count)}, i);
    i += count;
  }
}

}  // namespace

SubsetNumbers::SubsetNumbers(std::int64_t limit)
    : marks_(static_cast<std::size_t>((limit + kWordBits - 1) / kWordBits), 0) {}

void SubsetNumbers::add(std::span<const std::int32_t> numbers) {
  for (const std::int32_t number : numbers) {
    const std::atomic_ref word(marks_[number / kWordBits]);
    const std::uint64_t bit = std::uint64_t{1} << (number % kWordBits);
    // Most are there by a face before: no need to own the word then.
    if ((word.load(std::memory_order_relaxed) & bit) == 0)
      word.fetch_or(bit, std::memory_order_relaxed);
  }
}

void SubsetNumbers::finish() {
  constexpr std::size_t kWords = std::size_t{1} << 12;
  before_.resize(marks_.size());
  parallel_each(marks_.size(), kWords,
                [&](std::size_t w) { before_[w] = std::popcount(marks_[w]); });
  numbers_.resize(static_cast<std::size_t>(exclusive_sum(before_)));
  parallel_each(marks_.size(), kWords, [&](std::int32_t w) {
    std::int32_t* to = numbers_.data() + before_[w];
    for (std::uint64_t left = marks_[w]; left != 0; left &= left - 1)
      *to++ = w * kWordBits + std::countr_zero(left);
  });
}

std::int32_t SubsetNumbers::place_of(std::int32_t number) const {
  const auto word = static_cast<std::size_t>(number / kWordBits);
  const std::uint64_t lower = (std::uint64_t{1} << (number % kWordBits)) - 1;
  return before_[word] + std::popcount(marks_[word] & lower);
}

FaceRangeBlocks::FaceRangeBlocks(const SurfaceBlocks& surface, RowRange faces)
    : surface_(surface), faces_(faces) {
  const SurfaceInfo& all = surface.info();
  info_.level = all.level;
  info_.face_count = faces.count;
  info_.corner_count = all.first_corner(faces.first + faces.count) - all.first_corner(faces.first);
  info_.has_colors = all.has_colors;
  info_.has_groups = all.has_groups;
  info_.attributes = all.attributes;
  info_.groups = all.groups;
  info_.corners_per_face = all.corners_per_face;
  if (!all.face_offsets.empty()) {
    const auto begin = all.face_offsets.begin() + faces.first;
    info_.face_offsets.assign(begin, begin + faces.count + 1);
    for (std::int32_t& offset : info_.face_offsets) offset -= *begin;
  }
  find_numbers();
  info_.row_count = static_cast<std::int64_t>(rows_.all().size());
  info_.uv_count = static_cast<std::int64_t>(uvs_.all().size());
  for (const std::int32_t row : rows_.all()) {
    if (static_cast<std::size_t>(row) >= all.base_vertices.size()) break;
    info_.base_vertices.push_back(all.base_vertices[row]);
  }
}

void FaceRangeBlocks::find_numbers() {
  const SurfaceInfo& all = surface_.info();
  rows_ = SubsetNumbers(all.row_count);
  if (all.uv_count > 0) uvs_ = SubsetNumbers(all.uv_count);
  const std::vector<RowRange> pieces = ranges_of(faces_.count, kMarkedFaces);
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    RawVector<std::int32_t> numbers;
    for (std::size_t i = begin; i < end; ++i) {
      const RowRange piece = there(pieces[i]);
      numbers.resize(static_cast<std::size_t>(all.first_corner(piece.first + piece.count) -
                                              all.first_corner(piece.first)));
      surface_.face_vertices(piece, numbers);
      rows_.add(numbers);
      if (all.uv_count == 0) continue;
      surface_.face_uvs(piece, numbers);
      uvs_.add(numbers);
    }
  });
  rows_.finish();
  uvs_.finish();
}

// What is here of the surface's own blocks: most are here whole, and cheaper than rows by number.
std::vector<RowRange> FaceRangeBlocks::row_blocks(std::int64_t row_count) const {
  std::vector<RowRange> ranges;
  for (const RowRange& block : surface_.row_blocks(row_count)) {
    const auto place = [&](std::int64_t row) -> std::int64_t {
      return row < surface_.info().row_count ? rows_.place_of(static_cast<std::int32_t>(row))
                                             : info_.row_count;
    };
    const std::int64_t first = place(block.first), end = place(block.first + block.count);
    if (end > first) ranges.push_back({first, end - first});
  }
  return ranges;
}

DegenerateRows FaceRangeBlocks::rows(RowRange rows, const RowTarget& target) const {
  if (rows.count == 0) return {};
  const std::span<const std::int32_t> wanted = part(rows_, rows);
  if (wanted.back() - wanted.front() == static_cast<std::int32_t>(rows.count) - 1)
    return surface_.rows({wanted.front(), rows.count}, target);
  return surface_.rows_at(wanted, target);
}

void FaceRangeBlocks::face_vertices(RowRange faces, std::span<std::int32_t> rows) const {
  surface_.face_vertices(there(faces), rows);
  for (std::int32_t& row : rows) row = rows_.place_of(row);
}

void FaceRangeBlocks::face_uvs(RowRange faces, std::span<std::int32_t> uvs) const {
  surface_.face_uvs(there(faces), uvs);
  for (std::int32_t& uv : uvs) uv = uvs_.place_of(uv);
}

void FaceRangeBlocks::uvs(RowRange uvs, std::span<glm::dvec2> values) const {
  for_runs(part(uvs_, uvs), [&](RowRange there, std::size_t i) {
    surface_.uvs(there, values.subspan(i, static_cast<std::size_t>(there.count)));
  });
}

void FaceRangeBlocks::attribute(std::size_t index, RowRange rows, std::span<float> values) const {
  const auto width = static_cast<std::size_t>(info_.attributes[index].width);
  for_runs(part(rows_, rows), [&](RowRange there, std::size_t i) {
    surface_.attribute(index, there,
                       values.subspan(width * i, width * static_cast<std::size_t>(there.count)));
  });
}

}  // namespace planish
