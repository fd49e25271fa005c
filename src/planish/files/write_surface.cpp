#include "planish/files/write_surface.h"

#include <algorithm>
#include <mutex>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/files/gltf/gltf_face_writer.h"
#include "planish/files/write_polygons.h"

namespace planish {
namespace {

constexpr std::int64_t kTextRows = std::int64_t{1} << 13;

// Makes each piece when it is asked for.
class BlockSource final : public PolygonSource {
 public:
  BlockSource(const SurfaceBlocks& surface, const SurfaceWriteOptions& options)
      : surface_(surface),
        info_(surface.info()),
        header_(options.header),
        fields_(options.fields),
        is_z_up_(options.is_z_up) {
    totals_.row_count = info_.row_count;
    totals_.uv_count = info_.uv_count;
    totals_.face_count = info_.face_count;
    totals_.has_normals = true;
    totals_.corner_count = info_.corner_count;
    totals_.has_colors = info_.has_colors;
    totals_.has_uvs = info_.uv_count > 0;
    totals_.has_groups = info_.has_groups;
    totals_.materials = materials_of(info_.groups);
    totals_.largest_face = static_cast<std::size_t>(info_.corners_per_face);
    for (std::size_t f = 0; f + 1 < info_.face_offsets.size(); ++f) {
      totals_.largest_face =
          std::max(totals_.largest_face,
                   static_cast<std::size_t>(info_.face_offsets[f + 1] - info_.face_offsets[f]));
    }
  }

  [[nodiscard]] const PolygonTotals& totals() const override { return totals_; }
  [[nodiscard]] std::vector<RowRange> ranges(PolygonPart part) const override {
    if (part == PolygonPart::Head || part == PolygonPart::Tail) return {{0, 1}};
    if (part == PolygonPart::Uvs) return ranges_of(info_.uv_count, kTextRows);
    if (part == PolygonPart::Faces || part == PolygonPart::Triangles)
      return ranges_of(info_.face_count, kTextRows);
    return sorted(surface_.row_blocks(kTextRows));
  }
  void prepare(PolygonPart part) const override;
  /// Of the rows that were visited.
  [[nodiscard]] const DegenerateRows& degenerate() const { return degenerate_; }
  void visit(PolygonPart part, RowRange range,
             const std::function<void(const PolygonPiece&)>& use) const override {
    PolygonPiece piece{.part = part, .totals = totals_, .view = {}, .before = {}};
    if (part == PolygonPart::Head || part == PolygonPart::Tail) {
      piece.view.header = header_;
      piece.view.fields = fields_;
      piece.view.is_z_up = is_z_up_;
      return use(piece);
    }
    if (part == PolygonPart::Uvs) {
      RawVector<glm::dvec2> uvs(static_cast<std::size_t>(range.count));
      surface_.uvs(range, uvs);
      piece.view.uvs = uvs;
      return use(piece);
    }
    if (part == PolygonPart::Faces) return visit_faces(range, piece, use);
    if (part == PolygonPart::Triangles) return visit_triangles(range, piece, use);
    visit_rows(range, piece, use);
  }

 private:
  void visit_rows(RowRange range, PolygonPiece& piece,
                  const std::function<void(const PolygonPiece&)>& use) const;
  void visit_faces(RowRange range, PolygonPiece& piece,
                   const std::function<void(const PolygonPiece&)>& use) const;
  void visit_triangles(RowRange range, PolygonPiece& piece,
                       const std::function<void(const PolygonPiece&)>& use) const;

  const SurfaceBlocks& surface_;
  const SurfaceInfo& info_;
  std::span<const std::string> header_;
  std::span<const NamedField> fields_;
  bool is_z_up_;
  PolygonTotals totals_;
  mutable RawVector<glm::vec3> stored_;  // all rows, for triangles
  mutable std::mutex mutex_;
  mutable DegenerateRows degenerate_;
};

void BlockSource::visit_rows(RowRange range, PolygonPiece& piece,
                             const std::function<void(const PolygonPiece&)>& use) const {
  const auto count = static_cast<std::size_t>(range.count);
  const bool all = piece.part == PolygonPart::Vertices;
  const bool has_colors =
      all || piece.part == PolygonPart::Positions || piece.part == PolygonPart::Colors;
  RawVector<glm::dvec3> positions;
  RawVector<glm::vec3> normals;
  RawVector<glm::vec4> colors;
  std::vector<NamedField> fields;
  if (all || piece.part == PolygonPart::Positions) positions.resize(count);
  if (has_colors && info_.has_colors) colors.resize(count);
  if (all || piece.part == PolygonPart::Normals) normals.resize(count);
  RowTarget target;
  target.positions = positions;
  target.normals = normals;
  target.colors = colors;
  const DegenerateRows found = surface_.rows(range, target);
  if (found.count > 0) {
    const std::lock_guard lock(mutex_);
    degenerate_.add(found);
  }
  for (const NamedField& field : fields_)
    fields.push_back(
        {field.name, field.values.subspan(static_cast<std::size_t>(range.first), count)});
  piece.view.positions = positions;
  piece.view.normals = normals;
  piece.view.colors = colors;
  if (all || piece.part == PolygonPart::Fields) piece.view.fields = fields;
  use(piece);
}

void BlockSource::visit_faces(RowRange range, PolygonPiece& piece,
                              const std::function<void(const PolygonPiece&)>& use) const {
  const std::int64_t first = info_.first_corner(range.first);
  const auto count =
      static_cast<std::size_t>(info_.first_corner(range.first + range.count) - first);
  RawVector<std::int32_t> rows(count), uvs, groups;
  std::vector<std::int32_t> offsets;
  surface_.face_vertices(range, rows);
  piece.view.face_vertices = rows;
  if (info_.uv_count > 0) {
    uvs.resize(count);
    surface_.face_uvs(range, uvs);
    piece.view.face_uvs = uvs;
  }
  if (!info_.face_offsets.empty() || info_.corners_per_face != 4) {
    for (std::int64_t f = range.first; f <= range.first + range.count; ++f)
      offsets.push_back(static_cast<std::int32_t>(info_.first_corner(f) - first));
    piece.view.face_offsets = offsets;
  }
  if (info_.has_groups) {
    const std::int64_t before = range.first > 0 ? 1 : 0;
    groups.resize(static_cast<std::size_t>(range.count + before));
    surface_.face_groups({range.first - before, range.count + before}, groups);
    piece.view.groups = info_.groups;
    piece.view.face_groups = std::span(groups).subspan(static_cast<std::size_t>(before));
    if (before > 0) piece.before = info_.groups[groups.front()];
  }
  use(piece);
}

// The corners of a triangle are rows from all over, and neighbours' must be the same to the last
// bit: their positions are kept as the file has them.
void BlockSource::prepare(PolygonPart part) const {
  if (part != PolygonPart::Triangles || !stored_.empty()) return;
  stored_.resize(static_cast<std::size_t>(info_.row_count));
  const std::vector<RowRange> pieces = surface_.row_blocks(kTextRows);
  parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      RowTarget target;
      target.stored = std::span(stored_).subspan(static_cast<std::size_t>(pieces[i].first),
                                                 static_cast<std::size_t>(pieces[i].count));
      (void)surface_.rows(pieces[i], target);
    }
  });
}

void BlockSource::visit_triangles(RowRange range, PolygonPiece& piece,
                                  const std::function<void(const PolygonPiece&)>& use) const {
  static const GltfVertices kRows;
  RawVector<std::byte> bytes;
  FaceWriter<std::uint32_t>(surface_, kRows)(range, bytes);
  const std::span<const std::uint32_t> rows(reinterpret_cast<const std::uint32_t*>(bytes.data()),
                                            bytes.size() / sizeof(std::uint32_t));
  RawVector<glm::dvec3> positions(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) positions[i] = glm::dvec3(stored_[rows[i]]);
  piece.view.positions = positions;
  use(piece);
}

PolygonView view_of(const SurfaceMesh& surface, std::span<const std::string> header,
                    std::span<const NamedField> fields) {
  PolygonView view;
  view.positions = surface.positions;
  view.normals = surface.normals;
  view.face_offsets = surface.face_offsets;
  view.face_vertices = surface.face_vertices;
  view.uvs = surface.uvs;
  view.face_uvs = surface.face_uvs;
  view.colors = surface.colors;
  view.groups = surface.groups;
  view.face_groups = surface.face_groups;
  view.header = header;
  view.fields = fields;
  return view;
}

}  // namespace

void write_surface(const std::filesystem::path& path, FileFormat format, const SurfaceMesh& surface,
                   const std::vector<std::string>& header, std::span<const NamedField> fields) {
  write_polygons(path, format, view_of(surface, header, fields));
}

std::uint64_t write_surface(const std::filesystem::path& path, FileFormat format,
                            const SurfaceBlocks& surface, const SurfaceWriteOptions& options) {
  const BlockSource source(surface, options);
  std::size_t pieces = 0, written = 0;
  const FormatInfo& info = info_of(format);
  for (const PolygonPart part : kPolygonParts)
    if (!info.write_piece || info.polygon_parts(part)) pieces += source.ranges(part).size();
  const auto observe = [&](std::span<const std::byte> bytes) {
    if (options.observe) options.observe(bytes);
    ++written;
    options.callbacks.report(
        "write", std::min(1.0, static_cast<double>(written) / static_cast<double>(pieces)));
  };
  const std::uint64_t byte_count = write_polygons(path, format, source, options.header, observe);
  warn_of(source.degenerate(), options.callbacks);
  return byte_count;
}

}  // namespace planish
