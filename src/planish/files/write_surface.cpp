#include "planish/files/write_surface.h"

#include <algorithm>
#include <mutex>

#include "planish/core/callbacks.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/core/words.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/materials.h"
#include "planish/files/write_polygons.h"
#include "planish/files/writers.h"

namespace planish {
namespace {

constexpr std::int64_t kTextRows = std::int64_t{1} << 13;

// Makes each piece when it is asked for.
class BlockSource final : public PolygonSource {
 public:
  BlockSource(const SurfaceBlocks& surface, FileFormat format, const SurfaceWriteOptions& options)
      : surface_(surface),
        info_(surface.info()),
        format_(format),
        callbacks_(options.callbacks),
        progress_(options.callbacks, "write", 0, 1, expected_pieces(surface, format, options)),
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
  void visit(PolygonPart part, RowRange range,
             const std::function<void(const PolygonPiece&)>& use) const override {
    make(part, range, use);
    progress_.add();
  }
  // Warnings: a host's function may throw, and messages take memory.
  void finish() const override {
    warn_of(degenerate_, callbacks_);
    const std::string lost = lost_attributes(
        format_,
        {totals_.has_uvs, totals_.has_colors, info_.groups.size() > 1, !info_.attributes.empty()});
    if (!lost.empty()) callbacks_.warn({"lost-attributes", lost});
  }

 private:
  // Of the parts that the format asks for, where they are ordered here, or as its writer asks.
  static std::int64_t expected_pieces(const SurfaceBlocks& surface, FileFormat format,
                                      const SurfaceWriteOptions& options);
  void make(PolygonPart part, RowRange range,
            const std::function<void(const PolygonPiece&)>& use) const {
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
  void visit_rows(RowRange range, PolygonPiece& piece,
                  const std::function<void(const PolygonPiece&)>& use) const;
  void visit_faces(RowRange range, PolygonPiece& piece,
                   const std::function<void(const PolygonPiece&)>& use) const;
  void visit_triangles(RowRange range, PolygonPiece& piece,
                       const std::function<void(const PolygonPiece&)>& use) const;

  const SurfaceBlocks& surface_;
  const SurfaceInfo& info_;
  FileFormat format_;
  const Callbacks& callbacks_;
  mutable LoopProgress progress_;
  std::span<const std::string> header_;
  std::span<const NamedField> fields_;
  bool is_z_up_;
  PolygonTotals totals_;
  mutable RawVector<glm::vec3> stored_;  // all rows, for triangles
  mutable std::mutex mutex_;
  mutable DegenerateRows degenerate_;
};

std::int64_t BlockSource::expected_pieces(const SurfaceBlocks& surface, FileFormat format,
                                          const SurfaceWriteOptions& options) {
  const FormatInfo& info = info_of(format);
  const SurfaceInfo& made = surface.info();
  const auto count_of = [](std::int64_t count) { return (count + kTextRows - 1) / kTextRows; };
  const std::int64_t rows = std::ssize(surface.row_blocks(kTextRows)),
                     faces = count_of(made.face_count), uvs = count_of(made.uv_count);
  if (format == FileFormat::Stl) return rows + faces;
  // Sizes and corners of faces for themselves; colours are looked through before.
  if (info.parts.empty())
    return 2 * faces + uvs + rows * (made.has_colors ? 4 : 2) +
           rows * static_cast<std::int64_t>(options.fields.size());
  // PLY looks before which texture coordinates vertices have.
  std::int64_t pieces = format == FileFormat::Ply && uvs > 0 ? uvs + faces : 0;
  for (const PolygonPart part : info.parts) {
    const bool is_of_rows = part == PolygonPart::Positions || part == PolygonPart::Vertices ||
                            part == PolygonPart::Normals;
    pieces += is_of_rows                   ? rows
              : part == PolygonPart::Uvs   ? uvs
              : part == PolygonPart::Faces ? faces
                                           : 1;
  }
  return pieces;
}

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
  for (const NamedField& field : fields_) fields.push_back(field.part(range));
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
  parallel_each(pieces.size(), 1, [&](std::size_t i) {
    RowTarget target;
    target.stored = std::span(stored_).subspan(static_cast<std::size_t>(pieces[i].first),
                                               static_cast<std::size_t>(pieces[i].count));
    (void)surface_.rows(pieces[i], target);
    progress_.add();
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
  const HostScope host(options.callbacks);
  require_field_sizes(options.fields, surface.info().row_count, visible(path));
  const BlockSource source(surface, format, options);
  GivenMaterials materials = options.materials;
  UsdMaterials usd;
  if (format == FileFormat::Usda && materials.gltf != nullptr) {
    usd = usd_materials(*materials.gltf, source.totals().materials, materials.folder);
    for (const Warning& warning : usd.warnings)
      options.callbacks.warn({warning.code, visible(path) + ": " + warning.message, warning.count});
    materials.usd = &usd;
  }
  const std::uint64_t byte_count =
      write_polygons(path, format, source, options.header, options.observe, materials);
  options.callbacks.report("write", 1);
  return byte_count;
}

}  // namespace planish
