#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/raw_vector.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/mesh/face_geometry.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Around points; of none it is turned inside out.
struct FloatBox {
  glm::vec3 minimum{std::numeric_limits<float>::infinity()};
  glm::vec3 maximum{-std::numeric_limits<float>::infinity()};
  bool is_finite = true;  ///< all coordinates are; if not, the rest means nothing

  void add(const glm::vec3& point) {
    minimum = glm::min(minimum, point);
    maximum = glm::max(maximum, point);
  }
  /// Two boxes as one, of finite points.
  void add(const FloatBox& other) {
    minimum = glm::min(minimum, other.minimum);
    maximum = glm::max(maximum, other.maximum);
  }
};

/// The bounds of some points, four of them at a time as three vectors of four floats.
[[nodiscard]] inline FloatBox box_of(std::span<const glm::vec3> points) {
  typedef float Four __attribute__((vector_size(16)));
  typedef std::int32_t Flags __attribute__((vector_size(16)));
  static_assert(sizeof(glm::vec3) == 12);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Four low[3], high[3];
  for (int v = 0; v < 3; ++v) {
    low[v] = Four{} + kInfinity;
    high[v] = Four{} - kInfinity;
  }
  Flags finite = ~Flags{};
  const std::size_t fours = points.size() / 4 * 4;
  for (std::size_t i = 0; i < fours; i += 4) {
    Four values[3];
    std::memcpy(values, &points[i], sizeof(values));
    for (int v = 0; v < 3; ++v) {
      low[v] = values[v] < low[v] ? values[v] : low[v];
      high[v] = values[v] > high[v] ? values[v] : high[v];
      // Not of NaN, nor of infinite ones.
      finite &= values[v] - values[v] == Four{};
    }
  }
  FloatBox box;
  glm::vec3 lows[4], highs[4];
  std::memcpy(lows, low, sizeof(low));
  std::memcpy(highs, high, sizeof(high));
  for (int k = 0; k < 4; ++k) {
    box.minimum = glm::min(box.minimum, lows[k]);
    box.maximum = glm::max(box.maximum, highs[k]);
    box.is_finite = box.is_finite && finite[k] != 0;
  }
  for (std::size_t i = fours; i < points.size(); ++i) {
    box.minimum = glm::min(box.minimum, points[i]);
    box.maximum = glm::max(box.maximum, points[i]);
    for (int d = 0; d < 3; ++d) box.is_finite = box.is_finite && std::isfinite(points[i][d]);
  }
  return box;
}

/// Whether all lengths are within a tolerance of 1. A few that are may not count, so that no roots
/// are taken.
[[nodiscard]] inline bool are_surely_units(std::span<const glm::vec3> vectors, float tolerance) {
  const float most = 1.8f * tolerance;  // of a square: a little less than twice
  bool all = true;
  for (const glm::vec3& v : vectors) all &= std::abs(glm::dot(v, v) - 1.0f) <= most;
  return all;
}

/// How the writer turns a position in model coordinates into the float32 numbers of the file, and
/// what position these numbers stand for. The one place where rounding happens.
class StoredPosition {
 public:
  explicit StoredPosition(const GltfOptions& options)
      : origin_(options.origin), z_up_(options.z_up) {}

  [[nodiscard]] glm::vec3 store(const glm::dvec3& model) const {
    return upright(glm::vec3(model - origin_));
  }
  /// Exact inverse of the turn, then the origin added in double.
  [[nodiscard]] glm::dvec3 load(const glm::vec3& stored) const {
    return origin_ + unturn(glm::dvec3(stored));
  }
  /// A position of the file's scene, with its node's translation, in model coordinates.
  [[nodiscard]] glm::dvec3 unturn(const glm::dvec3& world) const {
    return z_up_ ? glm::dvec3(world.x, -world.z, world.y) : world;
  }
  /// Of a normal.
  [[nodiscard]] glm::vec3 turn(const glm::vec3& normal) const { return upright(normal); }
  /// node.translation.
  [[nodiscard]] glm::dvec3 translation() const { return upright(origin_); }

 private:
  // Adding zero turns -0 into 0, so that the sign of nothing is not stored.
  template <class Vector>
  [[nodiscard]] Vector upright(const Vector& v) const {
    return (z_up_ ? Vector(v.x, v.z, -v.y) : v) + Vector(0);
  }

  glm::dvec3 origin_;
  bool z_up_;
};

/// Throws Error{InvalidArgument} where faces or attributes of a surface in memory cannot be
/// written; numbers are checked by require_numbers() and gltf_bounds(). See encode_glb.
void require_writable(const SurfaceMesh& surface, const GltfOptions& options);

/// The same where there is no face, as where all of a mesh's are holes.
void require_a_face(std::int64_t face_count, const GltfOptions& options);

/// The same for numbers that are not finite, and fields that have none for each row.
void require_numbers(const SurfaceBlocks& surface, const GltfOptions& options);

/// Throws Error{InvalidArgument}, naming the surface.
[[noreturn]] void refuse_to_write(const GltfOptions& options, const std::string& what,
                                  std::int64_t element = Error::kNoElement);

/// A texture coordinate from an origin at the bottom left to glTF's at the top left.
[[nodiscard]] inline glm::vec2 stored_uv(const glm::dvec2& uv) { return {uv.x, 1.0 - uv.y}; }

/// Faces of one group: a primitive of the file.
struct GltfPart {
  std::int32_t group = -1;  ///< -1: the surface has no groups
  std::int64_t first_vertex = 0, vertex_count = 0;
  int uv_sets = 0;  ///< sets of texture coordinates
  std::uint64_t face_count = 0, triangle_count = 0;
  std::vector<RowRange> faces;  ///< ascending
};

/// A corner of the surface that has not its row's first vertex.
struct SeamCorner {
  std::int64_t corner;
  std::int32_t vertex;
};

/// A surface as glTF has it: one texture coordinate a vertex, and vertices of its own for each
/// primitive, since readers that count by primitive would hold shared ones again and again.
struct GltfVertices {
  std::int64_t kept_rows = 0;      ///< so many of the surface's rows are the first vertices
  std::vector<std::int32_t> rows;  ///< the surface's row of each vertex behind those
  std::vector<std::int32_t>
      uvs;  ///< texture coordinate of each vertex; empty: none; -1: none there
  RawVector<std::int32_t> corners;  ///< vertex of each corner in its primitive; empty: its row,
  std::vector<SeamCorner> seams;    ///< but for these, ascending
  std::vector<GltfPart> parts;      ///< one for each group that has faces, at least one

  [[nodiscard]] std::int64_t count() const {
    return kept_rows + static_cast<std::int64_t>(rows.size());
  }
  [[nodiscard]] std::int64_t row_of(std::int64_t vertex) const {
    return vertex < kept_rows ? vertex : rows[vertex - kept_rows];
  }
};

/// Splits vertices along the seams of the texture coordinates and between primitives. Of one
/// primitive the surface's rows stay the first vertices, in their order: each takes the texture
/// coordinate of its first corner, every other gets a vertex of its own behind them. Several have
/// each the rows of its faces, in their order, and such copies behind them. Sets of texture
/// coordinates are as the options say.
[[nodiscard]] GltfVertices gltf_vertices(const SurfaceBlocks& surface, const GltfOptions& options);

/// A vertex behind the kept rows, by its row: sorted by row, then by vertex.
struct CopiedRow {
  std::int32_t row;
  std::int64_t vertex;
  [[nodiscard]] bool operator<(const CopiedRow& other) const {
    return row != other.row ? row < other.row : vertex < other.vertex;
  }
};
[[nodiscard]] std::vector<CopiedRow> copied_rows(const GltfVertices& vertices);
/// Those of a range of rows, out of all copies.
[[nodiscard]] std::span<const CopiedRow> copies_in(std::span<const CopiedRow> copied,
                                                   RowRange range);

/// Writes the triangle indices of ranges of faces; keeps its memory.
template <class Index>
class FaceWriter {
 public:
  FaceWriter(const SurfaceBlocks& surface, const GltfVertices& vertices)
      : surface_(surface), vertices_(vertices) {}

  void operator()(RowRange faces, RawVector<std::byte>& bytes) {
    const SurfaceInfo& info = surface_.info();
    const std::int64_t first = info.first_corner(faces.first);
    const std::int64_t last = info.first_corner(faces.first + faces.count);
    take_corners(faces, static_cast<std::size_t>(first), static_cast<std::size_t>(last - first));
    const auto triangles = static_cast<std::size_t>(last - first - 2 * faces.count);
    Index* to = values_of<Index>(bytes, 3 * triangles).data();
    if (info.face_offsets.empty() && info.corners_per_face == 4) return quads(faces, to);
    positions_.resize(corners_.size());
    normals_.resize(corners_.size());
    surface_.corners(faces, positions_, normals_);
    for (std::int64_t f = faces.first; f < faces.first + faces.count; ++f) {
      const auto begin = static_cast<std::size_t>(info.first_corner(f) - first);
      const auto end = static_cast<std::size_t>(info.first_corner(f + 1) - first);
      to = end - begin == 4 ? quad(begin, to) : polygon(begin, end - begin, to);
    }
  }

  /// The same as FB_ngon_encoding has it: triangles of one face follow each other and begin with
  /// one vertex, which is none that those of the face before it, `before` (-1: none), could begin
  /// with. Faces of more than `most_fanned` corners are triangles of their own, for those of a fan
  /// overlap where a face is concave.
  void ngons(RowRange faces, std::int64_t before, std::size_t most_fanned,
             RawVector<std::byte>& bytes) {
    const SurfaceInfo& info = surface_.info();
    std::vector<Index> taken;
    if (before >= 0) {
      take_with_positions({before, 1});
      taken.assign(corners_.begin(), corners_.end());
    }
    take_with_positions(faces);
    const std::int64_t first = info.first_corner(faces.first);
    const std::size_t triangles = corners_.size() - 2 * static_cast<std::size_t>(faces.count);
    Index* to = values_of<Index>(bytes, 3 * triangles).data();
    for (std::int64_t f = faces.first; f < faces.first + faces.count; ++f) {
      const auto begin = static_cast<std::size_t>(info.first_corner(f) - first);
      const auto end = static_cast<std::size_t>(info.first_corner(f + 1) - first);
      Index* const written = to;
      if (end - begin >= 4 && end - begin <= most_fanned) {
        to = end - begin == 4 ? quad_fan(begin, taken, to) : fan(begin, end - begin, taken, to);
        taken = {*written};
        continue;
      }
      to = polygon(begin, end - begin, to);
      for (Index* triangle = written; triangle < to; triangle += 3) {
        for (int turn = 0; turn < 2 && is_in(taken, triangle[0]); ++turn)
          std::rotate(triangle, triangle + 1, triangle + 3);
        taken = {triangle[0]};
      }
    }
  }

 private:
  void take_with_positions(RowRange faces) {
    const std::int64_t first = surface_.info().first_corner(faces.first);
    const std::int64_t last = surface_.info().first_corner(faces.first + faces.count);
    take_corners(faces, static_cast<std::size_t>(first), static_cast<std::size_t>(last - first));
    positions_.resize(corners_.size());
    normals_.resize(corners_.size());
    surface_.corners(faces, positions_, normals_);
  }

  [[nodiscard]] static bool is_in(const std::vector<Index>& taken, Index vertex) {
    return std::ranges::find(taken, vertex) != taken.end();
  }

  // The triangles of a polygon around a corner that is not taken.
  Index* fan(std::size_t at, std::size_t size, const std::vector<Index>& taken, Index* to) const {
    std::size_t start = 0;
    while (start + 1 < size && is_in(taken, static_cast<Index>(corners_[at + start]))) ++start;
    for (std::size_t k = 1; k + 1 < size; ++k)
      for (const std::size_t corner : {start, start + k, start + k + 1})
        *to++ = static_cast<Index>(corners_[at + corner % size]);
    return to;
  }

  // The two triangles of a quad at an end of the diagonal that cuts it, one that is not taken.
  Index* quad_fan(std::size_t at, const std::vector<Index>& taken, Index* to) const {
    const glm::dvec3* p = positions_.data() + at;
    const auto split = split_quad(p[0], p[1], p[2], p[3]);
    std::size_t start = split[0] == split[3] ? 0 : 1;
    if (is_in(taken, static_cast<Index>(corners_[at + start]))) start += 2;
    for (std::size_t k = 1; k < 3; ++k)
      for (const std::size_t corner : {start, start + k, start + k + 1})
        *to++ = static_cast<Index>(corners_[at + corner % 4]);
    return to;
  }

  void take_corners(RowRange faces, std::size_t first, std::size_t count) {
    if (!vertices_.corners.empty()) {
      corners_ = std::span(vertices_.corners).subspan(first, count);
      return;
    }
    rows_.resize(count);
    surface_.face_vertices(faces, rows_);
    const auto begin = static_cast<std::int64_t>(first);
    for (auto seam = std::ranges::lower_bound(vertices_.seams, begin, {}, &SeamCorner::corner);
         seam != vertices_.seams.end() && seam->corner < begin + std::ssize(rows_); ++seam)
      rows_[seam->corner - begin] = seam->vertex;
    corners_ = rows_;
  }

  void quads(RowRange faces, Index* to) {
    cuts_.resize(static_cast<std::size_t>(faces.count));
    surface_.cuts(faces, cuts_);
    const std::int32_t* c = corners_.data();
    for (const std::uint8_t from_1 : cuts_) {
      const Index a = static_cast<Index>(c[0]), b = static_cast<Index>(c[1]);
      const Index d = static_cast<Index>(c[2]), e = static_cast<Index>(c[3]);
      to[0] = a, to[1] = b, to[2] = from_1 != 0 ? e : d;
      to[3] = from_1 != 0 ? b : a, to[4] = d, to[5] = e;
      c += 4, to += 6;
    }
  }

  Index* quad(std::size_t at, Index* to) const {
    const glm::dvec3* p = positions_.data() + at;
    for (const std::uint8_t k : split_quad(p[0], p[1], p[2], p[3])) {
      *to++ = static_cast<Index>(corners_[at + k]);
    }
    return to;
  }

  Index* polygon(std::size_t at, std::size_t size, Index* to) {
    numbers_.resize(size);
    std::iota(numbers_.begin(), numbers_.end(), 0);
    triangles_.resize(3 * (size - 2));
    triangulate(numbers_, std::span(positions_).subspan(at, size), triangles_);
    for (const std::uint32_t k : triangles_) *to++ = static_cast<Index>(corners_[at + k]);
    return to;
  }

  const SurfaceBlocks& surface_;
  const GltfVertices& vertices_;
  RawVector<glm::dvec3> positions_;  // at the corners
  RawVector<glm::vec3> normals_;
  RawVector<std::int32_t> rows_;
  RawVector<std::uint8_t> cuts_;
  std::span<const std::int32_t> corners_;
  std::vector<std::int32_t> numbers_;
  std::vector<std::uint32_t> triangles_;
};

}  // namespace planish
