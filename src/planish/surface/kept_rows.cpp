#include "planish/surface/kept_rows.h"

#include <algorithm>
#include <mutex>

#include "planish/core/raw_vector.h"
#include "planish/mesh/quad_cut.h"
#include "planish/surface/piece_loop.h"

namespace planish {

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

}  // namespace planish
