#include "planish/files/writers.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <limits>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/files/shared/attributes.h"

namespace planish {

namespace {

// The texture coordinates of the whole surface: faces and vertices name them in any order.
class PlyUvs {
 public:
  explicit PlyUvs(const PolygonStream& stream) {
    if (!stream.totals().has_uvs || stream.totals().uv_count == 0) return;
    values_.resize(static_cast<std::size_t>(stream.totals().uv_count));
    stream.look(PolygonPart::Uvs, [&](const PolygonPiece& piece, RowRange range) {
      for (std::size_t i = 0; i < piece.view.uvs.size(); ++i)
        values_[static_cast<std::size_t>(range.first) + i] = glm::vec2(piece.view.uvs[i]);
    });
    const std::size_t wild = first_where(values_.size(), [&](std::size_t i) {
      return !std::isfinite(values_[i].x) || !std::isfinite(values_[i].y);
    });
    if (wild < values_.size())
      throw Error(
          ErrorCode::InvalidArgument,
          formatted("{}: texture coordinate {} is not finite in float32", stream.name(), wild),
          static_cast<std::int64_t>(wild));
    has_seams_ = !find_vertices(stream);
    if (has_seams_) of_vertices_ = {};
  }

  /// Where every corner at a vertex has the same coordinates: of the vertices.
  [[nodiscard]] bool are_of_vertices() const { return !values_.empty() && !has_seams_; }
  [[nodiscard]] bool are_of_faces() const { return has_seams_; }
  [[nodiscard]] glm::vec2 of_vertex(std::int64_t vertex) const {
    const std::int32_t uv = of_vertices_[vertex];
    return uv < 0 ? glm::vec2(0.0f) : values_[uv];
  }
  [[nodiscard]] const glm::vec2& at(std::int32_t uv) const { return values_[uv]; }

 private:
  [[nodiscard]] bool are_equal(std::int32_t a, std::int32_t b) const {
    return std::bit_cast<std::uint64_t>(values_[a]) == std::bit_cast<std::uint64_t>(values_[b]);
  }
  // Whether each vertex has one. Any corner's will do, for all of them are the same then.
  bool find_vertices(const PolygonStream& stream) {
    of_vertices_.assign(static_cast<std::size_t>(stream.totals().row_count), -1);
    std::atomic<bool> is_one{true};
    stream.look(PolygonPart::Faces, [&](const PolygonPiece& piece, RowRange) {
      const PolygonView& view = piece.view;
      for (std::size_t c = 0; c < view.face_uvs.size(); ++c) {
        std::int32_t found = -1;
        const std::int32_t uv = view.face_uvs[c];
        const bool is_same =
            uv >= 0 && (std::atomic_ref(of_vertices_[view.face_vertices[c]])
                            .compare_exchange_strong(found, uv, std::memory_order_relaxed) ||
                        are_equal(found, uv));
        if (!is_same) is_one = false;
      }
    });
    return is_one;
  }

  std::vector<glm::vec2> values_;
  std::vector<std::int32_t> of_vertices_;
  bool has_seams_ = false;
};

constexpr std::size_t kMostShortPly = std::numeric_limits<std::uint8_t>::max();

bool has_short_counts(const PolygonTotals& totals) { return totals.largest_face <= kMostShortPly; }
bool has_short_uv_counts(const PolygonTotals& totals) {
  return 2 * totals.largest_face <= kMostShortPly;
}

void write_ply_header(FileBuffer& out, const PolygonPiece& piece, const PlyUvs& uvs) {
  const PolygonTotals& totals = piece.totals;
  out.text("ply\nformat binary_little_endian 1.0\n");
  for (const std::string& line : piece.view.header) out.text("comment ").text(line).text("\n");
  out.text("element vertex ").number(totals.row_count);
  out.text("\nproperty double x\nproperty double y\nproperty double z\n");
  if (totals.has_normals) out.text("property float nx\nproperty float ny\nproperty float nz\n");
  if (totals.has_colors)
    out.text(
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n");
  if (uvs.are_of_vertices()) out.text("property float s\nproperty float t\n");
  for (const NamedField& field : piece.view.fields)
    for (int k = 0; k < field.width; ++k) {
      out.text("property float ").text(field.name);
      if (field.width > 1) out.text("_").number(k);
      out.text("\n");
    }
  out.text("element face ").number(totals.face_count);
  out.text(has_short_counts(totals) ? "\nproperty list uchar" : "\nproperty list int");
  out.text(" int vertex_indices\n");
  if (uvs.are_of_faces())
    out.text(has_short_uv_counts(totals) ? "property list uchar float texcoord\n"
                                         : "property list int float texcoord\n");
  out.text("end_header\n");
}

void write_uv(FileBuffer& out, const glm::vec2& uv) { out.binary(uv.x).binary(uv.y); }

void write_ply_vertices(FileBuffer& out, const PolygonView& view, std::int64_t first,
                        const PlyUvs& uvs) {
  for (std::size_t i = 0; i < view.positions.size(); ++i) {
    const glm::dvec3& position = view.positions[i];
    out.binary(position.x).binary(position.y).binary(position.z);
    if (!view.normals.empty()) {
      const glm::vec3& normal = view.normals[i];
      out.binary(normal.x).binary(normal.y).binary(normal.z);
    }
    if (!view.colors.empty()) {
      const glm::dvec4 encoded = srgb_of_linear(view.colors[i]);
      for (int k = 0; k < 4; ++k)
        out.binary(static_cast<std::uint8_t>(std::lround(255 * encoded[k])));
    }
    if (uvs.are_of_vertices()) write_uv(out, uvs.of_vertex(first + static_cast<std::int64_t>(i)));
    for (const NamedField& field : view.fields) {
      const auto width = static_cast<std::size_t>(field.width);
      for (std::size_t k = 0; k < width; ++k) out.binary(field.values[width * i + k]);
    }
  }
}

void write_count(FileBuffer& out, std::size_t count, bool is_short) {
  if (is_short) {
    out.binary(static_cast<std::uint8_t>(count));
  } else {
    out.binary(static_cast<std::int32_t>(count));
  }
}

void write_ply_faces(FileBuffer& out, const PolygonPiece& piece, const PlyUvs& uvs) {
  std::size_t corner = 0;
  for (std::size_t face = 0; face < piece.view.face_count(); ++face) {
    const auto corners = piece.view.face(face);
    write_count(out, corners.size(), has_short_counts(piece.totals));
    for (const std::int32_t vertex : corners) out.binary(vertex);
    if (!uvs.are_of_faces()) continue;
    const auto named = piece.view.face_uvs.subspan(corner, corners.size());
    corner += corners.size();
    const bool has_all = std::ranges::none_of(named, [](std::int32_t uv) { return uv < 0; });
    write_count(out, has_all ? 2 * named.size() : 0, has_short_uv_counts(piece.totals));
    for (const std::int32_t uv : has_all ? named : named.first(0)) write_uv(out, uvs.at(uv));
  }
}

}  // namespace

void write_ply(const PolygonStream& stream) {
  const PlyUvs uvs(stream);
  for (const PolygonPart part : kPlyParts) {
    stream.part(part, [&](FileBuffer& out, const PolygonPiece& piece, RowRange range) {
      if (part == PolygonPart::Head) write_ply_header(out, piece, uvs);
      if (part == PolygonPart::Vertices) write_ply_vertices(out, piece.view, range.first, uvs);
      if (part == PolygonPart::Faces) write_ply_faces(out, piece, uvs);
    });
  }
}

}  // namespace planish
