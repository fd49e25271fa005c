#include "planish/files/write_polygons.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string_view>

#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/files/obj/material_library.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/files/writers.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/sound_topology.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

void require_field_sizes(std::span<const NamedField> fields, std::int64_t row_count,
                         const std::string& name) {
  for (const NamedField& field : fields)
    if (field.values.size() != static_cast<std::size_t>(field.width * row_count))
      throw Error(ErrorCode::InvalidArgument,
                  formatted("{}: {} values of {} for {} positions", name, field.values.size(),
                            field.name, row_count));
}

void require_writable(const PolygonView& view, const std::string& name) {
  constexpr std::int32_t kLeastCorners = 3;
  require_sound_indices({.vertex_count = view.positions.size(),
                         .face_offsets = view.face_offsets,
                         .face_vertices = view.face_vertices,
                         .uv_count = view.uvs.size(),
                         .face_uvs = view.face_uvs,
                         .color_count = view.colors.size(),
                         .group_count = view.groups.size(),
                         .face_groups = view.face_groups,
                         .hole_faces = view.hole_faces,
                         .creases = view.creases,
                         .corners = view.corners},
                        name, ErrorCode::InvalidArgument, kLeastCorners);
  if (!view.normals.empty() && view.normals.size() != view.positions.size())
    throw Error(ErrorCode::InvalidArgument, formatted("{}: {} normals for {} positions", name,
                                                      view.normals.size(), view.positions.size()));
  require_field_sizes(view.fields, static_cast<std::int64_t>(view.positions.size()), name);
}

namespace {

constexpr std::int64_t kWrittenRows = std::int64_t{1} << 13;

bool fits_float(const glm::dvec3& p) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return std::abs(p.x) <= kMost && std::abs(p.y) <= kMost && std::abs(p.z) <= kMost;
}
bool fits_float(const glm::dvec2& p) { return fits_float(glm::dvec3(p, 0.0)); }
bool is_finite_piece(const PolygonView& view) {
  return all_finite(view.positions) && all_finite(view.uvs) && all_finite(view.colors) &&
         all_finite(view.normals) && std::ranges::all_of(view.fields, [](const NamedField& field) {
           return all_finite(field.values);
         });
}

void require_finite_piece(const PolygonView& view, std::int64_t first, const std::string& name) {
  require_finite(view.positions, first, "vertex", name);
  require_finite(view.uvs, first, "texture coordinate", name);
  require_finite(view.colors, first, "the colour of vertex", name);
  require_finite(view.normals, first, "the normal of vertex", name);
  for (const NamedField& field : view.fields)
    require_finite(field.values, first, field.name + " of vertex", name,
                   static_cast<std::size_t>(field.width));
}

template <class Vector>
bool all_fit_floats(std::span<const Vector> values) {
  return std::ranges::all_of(values, [](const Vector& v) { return fits_float(v); });
}

template <class Vector>
void require_floats(std::span<const Vector> values, std::int64_t first, const std::string& what,
                    const std::string& remedy, const std::string& name) {
  const auto wild = std::ranges::find_if_not(values, [](const Vector& v) { return fits_float(v); });
  if (wild == values.end()) return;
  const std::int64_t element = first + (wild - values.begin());
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: {} {} has a coordinate that float32 cannot hold; {}", name, what,
                        element, remedy),
              element);
}

void require_floats(const PolygonView& view, std::int64_t first, const std::string& name) {
  require_floats(view.positions, first, "vertex", "scale the model down", name);
  require_floats(view.uvs, first, "texture coordinate", "bring it near 0 to 1", name);
}

void require_lines(std::span<const std::string> header, const std::string& name) {
  for (const std::string& line : header)
    if (line.find_first_of("\r\n") != std::string::npos)
      throw Error(ErrorCode::InvalidArgument, name + ": a header line holds a line break");
}

// Polygons in memory.
class ViewSource final : public PolygonSource {
 public:
  explicit ViewSource(const PolygonView& view) : view_(view) {
    totals_.row_count = static_cast<std::int64_t>(view.positions.size());
    totals_.uv_count = static_cast<std::int64_t>(view.uvs.size());
    totals_.face_count = static_cast<std::int64_t>(view.face_count());
    totals_.corner_count = static_cast<std::int64_t>(view.face_vertices.size());
    totals_.has_normals = !view.normals.empty();
    totals_.has_colors = !view.colors.empty();
    totals_.has_uvs = !view.face_uvs.empty();
    totals_.has_groups = !view.face_groups.empty();
    totals_.materials = materials_of(view.groups);
    for (std::size_t face = 0; face < view.face_count(); ++face)
      totals_.largest_face = std::max(totals_.largest_face, view.face(face).size());
  }

  [[nodiscard]] const PolygonTotals& totals() const override { return totals_; }
  [[nodiscard]] std::vector<RowRange> ranges(PolygonPart part) const override {
    switch (part) {
      case PolygonPart::Head:
      case PolygonPart::Tail:
        return {{0, 1}};
      case PolygonPart::Uvs:
        return ranges_of(totals_.uv_count, kWrittenRows);
      case PolygonPart::Normals:
        if (!totals_.has_normals) return {};
        [[fallthrough]];
      case PolygonPart::Positions:
      case PolygonPart::Vertices:
      case PolygonPart::Colors:
      case PolygonPart::Fields:
        return ranges_of(totals_.row_count, kWrittenRows);
      case PolygonPart::Faces:
      case PolygonPart::Triangles:
        return ranges_of(totals_.face_count, kWrittenRows);
    }
    return {};
  }
  void visit(PolygonPart part, RowRange range,
             const std::function<void(const PolygonPiece&)>& use) const override {
    PolygonPiece piece{.part = part, .totals = totals_, .view = {}, .before = {}};
    PolygonView& view = piece.view;
    std::vector<std::int32_t> offsets;
    std::vector<NamedField> fields;
    std::vector<glm::dvec3> triangles;
    const auto some = [&](const auto& values) {
      return values.empty() ? values
                            : values.subspan(static_cast<std::size_t>(range.first),
                                             static_cast<std::size_t>(range.count));
    };
    switch (part) {
      case PolygonPart::Head:
      case PolygonPart::Tail:
        view.header = view_.header;
        view.fields = view_.fields;
        view.creases = view_.creases;
        view.corners = view_.corners;
        view.hole_faces = view_.hole_faces;
        view.subdivision = view_.subdivision;
        view.is_z_up = view_.is_z_up;
        break;
      case PolygonPart::Uvs:
        view.uvs = some(view_.uvs);
        break;
      case PolygonPart::Colors:
        view.colors = some(view_.colors);
        break;
      case PolygonPart::Vertices:
      case PolygonPart::Fields:
        for (const NamedField& field : view_.fields) fields.push_back(field.part(range));
        view.fields = fields;
        if (part == PolygonPart::Fields) break;
        [[fallthrough]];
      case PolygonPart::Positions:
        view.positions = some(view_.positions);
        view.colors = some(view_.colors);
        if (part == PolygonPart::Positions) break;
        [[fallthrough]];
      case PolygonPart::Normals:
        view.normals = some(view_.normals);
        break;
      case PolygonPart::Faces:
        take_faces(range, piece, offsets);
        break;
      case PolygonPart::Triangles:
        take_triangles(range, triangles);
        view.positions = triangles;
        break;
    }
    use(piece);
  }

 private:
  void take_triangles(RowRange range, std::vector<glm::dvec3>& positions) const {
    std::vector<std::uint32_t> triangles;
    for (std::int64_t face = range.first; face < range.first + range.count; ++face) {
      const auto corners = view_.face(static_cast<std::size_t>(face));
      triangles.resize(3 * (corners.size() - 2));
      if (corners.size() == 4) {
        const auto split = split_quad(view_.positions[corners[0]], view_.positions[corners[1]],
                                      view_.positions[corners[2]], view_.positions[corners[3]]);
        for (std::size_t i = 0; i < split.size(); ++i)
          triangles[i] = static_cast<std::uint32_t>(corners[split[i]]);
      } else {
        triangulate(corners, view_.positions, triangles);
      }
      // Rounded here, so that they are what a surface made in pieces gives.
      for (const std::uint32_t vertex : triangles)
        positions.emplace_back(glm::vec3(view_.positions[vertex]));
    }
  }
  void take_faces(RowRange range, PolygonPiece& piece, std::vector<std::int32_t>& offsets) const {
    const auto corner = [&](std::int64_t face) {
      return view_.face_offsets.empty() ? static_cast<std::size_t>(4 * face)
                                        : static_cast<std::size_t>(view_.face_offsets[face]);
    };
    const std::size_t first = corner(range.first),
                      count = corner(range.first + range.count) - first;
    PolygonView& view = piece.view;
    view.face_vertices = view_.face_vertices.subspan(first, count);
    if (!view_.face_uvs.empty()) view.face_uvs = view_.face_uvs.subspan(first, count);
    if (!view_.face_offsets.empty()) {
      for (std::int64_t f = range.first; f <= range.first + range.count; ++f)
        offsets.push_back(static_cast<std::int32_t>(corner(f) - first));
      view.face_offsets = offsets;
    }
    if (view_.face_groups.empty()) return;
    view.groups = view_.groups;
    view.face_groups = view_.face_groups.subspan(static_cast<std::size_t>(range.first),
                                                 static_cast<std::size_t>(range.count));
    if (range.first > 0) piece.before = view_.groups[view_.face_groups[range.first - 1]];
  }

  const PolygonView& view_;
  PolygonTotals totals_;
};

// A file, who watches it, and how much of it there is.
class CountedFile {
 public:
  CountedFile(const std::filesystem::path& path, const ByteObserver& observe) : file_(path) {
    sinks_.push_back([this](std::span<const std::byte> bytes) {
      file_.write(bytes);
      byte_count_ += bytes.size();
    });
    if (observe) sinks_.push_back(observe);
  }
  [[nodiscard]] std::span<const ByteSink> sinks() const { return sinks_; }
  std::uint64_t commit() {
    file_.commit();
    return byte_count_;
  }

 private:
  OutputFile file_;
  std::uint64_t byte_count_ = 0;
  std::vector<ByteSink> sinks_;
};

}  // namespace

bool PolygonStream::can_write(const PolygonView& view) const {
  return is_finite_piece(view) &&
         (format_.keeps_doubles || (all_fit_floats(view.positions) && all_fit_floats(view.uvs)));
}

// The first fault in order.
void PolygonStream::refuse(PolygonPart part) const {
  // Triangles do not know the vertices' numbers.
  const PolygonPart looked = part == PolygonPart::Triangles ? PolygonPart::Positions : part;
  for (const RowRange& range : source_.ranges(looked)) {
    source_.visit(looked, range, [&](const PolygonPiece& piece) {
      require_finite_piece(piece.view, range.first, name_);
      if (!format_.keeps_doubles) require_floats(piece.view, range.first, name_);
    });
  }
  throw Error(ErrorCode::InvalidArgument, name_ + ": a number is not finite");
}

std::vector<std::string> materials_of(std::span<const FaceGroup> groups) {
  std::vector<std::string> materials;
  std::set<std::string_view> known = {""};
  for (const FaceGroup& group : groups)
    if (known.insert(group.material).second) materials.push_back(group.material);
  return materials;
}

std::uint64_t write_polygons(const std::filesystem::path& path, FileFormat format,
                             const PolygonSource& source, std::span<const std::string> header,
                             const ByteObserver& observe, const GivenMaterials& materials) {
  const FormatInfo& info = info_of(format);
  const std::string name = visible(path);
  if (!info.write_polygons)
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: polygons are written as {}, not as .{}", name,
                          extensions_in_words(FormatUse::WriteMesh), info.name));
  require_lines(header, name);
  if (materials.library != nullptr) require_apart(materials.library->obj(), path, format);
  std::optional<OutputFile> library;
  std::string companion;
  if (format == FileFormat::Obj && !source.totals().materials.empty()) {
    const std::filesystem::path beside = companion_of(path, format);
    if (beside != path) {
      write_mtl(library.emplace(beside), source.totals().materials, materials);
      companion = utf8(beside.filename());
    }
  }
  CountedFile file(path, observe);
  info.write_polygons(PolygonStream(source, file.sinks(), info, name, companion, materials.usd));
  source.finish();
  if (library) library->commit();
  return file.commit();
}

std::uint64_t write_polygons(const std::filesystem::path& path, FileFormat format,
                             const PolygonView& view, const ByteObserver& observe,
                             const GivenMaterials& materials) {
  require_writable(view, visible(path));
  return write_polygons(path, format, ViewSource(view), view.header, observe, materials);
}

}  // namespace planish
