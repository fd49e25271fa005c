#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <type_traits>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_plan.h"

namespace planish {

/// What each corner of a mesh has of its texture coordinates: one past the given ones where it has
/// none.
struct CornerUvs {
  explicit CornerUvs(const PolygonMesh& mesh)
      : indices(mesh.face_uvs), count(static_cast<std::int32_t>(mesh.uvs.size())) {
    bool missing = false;
    for (std::int32_t& uv : indices) {
      if (uv < 0) uv = static_cast<std::int32_t>(mesh.uvs.size()), missing = true;
    }
    if (missing) ++count;
  }
  std::vector<std::int32_t> indices;
  std::int32_t count;
};

/// Where a surface has the vertices of its mesh, by its control points of level 1; of vertices
/// without faces 0.
[[nodiscard]] RawVector<glm::dvec3> vertex_limits(const PatchMesh& mesh,
                                                  std::span<const glm::dvec3> points);

/// What is given at the corners of a mesh as a field on its surface: texture coordinates (two
/// numbers), or colours and other values (four).
/// The field has control values where the surface has control points, and its rows are the
/// surface's, so that it lies on the surface where it lay on the mesh: where it is an affine
/// function of the place on flat faces, it is the same function on their flat surface. Given
/// vertices keep their values.
///
/// A chart is made of faces whose values agree along the edges between them. Control values are
/// those of an affine map of the control points around a vertex, one for all faces of a chart that
/// lie between sharp edges there; past the chart's border its map goes on, so that on both sides of
/// a seam the border is the same curve on the surface. Where charts differ by a translation alone,
/// as a texture that goes once around does from its end to its beginning, they have one gradient
/// there, as if there were no seam: along it they change alike, and from face to face across it by
/// no more than within either. Mirrored charts are apart where both have indices of their own
/// along their axis, be the values the same. Curve points go by the chart's values along the curve:
/// a straight border stays straight.
///
/// Coordinates must not fold where those at the corners do not: the map of a chart around a vertex
/// is shrunk towards the vertex's value until each control value lies in its own quarter of the
/// face, or no further past it than its control point. Values must not swing over: the map is
/// shrunk until each control value lies between those at the face's corners, or no further than the
/// face's own affine map, and no row leaves the range of what is given. Affine functions are never
/// shrunk; numbers of one attribute are shrunk alike, so that shares of a whole add up to it.
template <class Vector>
class ChartField {
 public:
  /// Whether these are texture coordinates.
  static constexpr bool kIsCoordinates = Vector::length() == 2;
  /// What is given, and kept: values in float, as files have them.
  using Stored = std::conditional_t<kIsCoordinates, Vector, glm::vec4>;

  /// `points`: the state of level 1 with the sums of large rings (PatchMesh::point_count()); they
  /// need not outlive the field, all else must. `indices` names one of the values at each corner;
  /// those behind them are 0. `limits`: vertex_limits(), where some of the vertices' faces are
  /// missing here. `attributes`: a number for each attribute that the four are of. `elsewhere`:
  /// values of the whole whose part this is, between which rows may lie, too.
  ChartField(const PatchMesh& mesh, std::span<const glm::dvec3> points,
             std::span<const std::int32_t> indices, std::span<const Stored> values,
             std::span<const glm::dvec3> limits = {}, const std::array<int, 4>& attributes = {},
             std::span<const Stored> elsewhere = {});

  [[nodiscard]] const PatchMesh& mesh() const { return mesh_; }
  [[nodiscard]] std::span<const std::int32_t> indices() const { return indices_; }
  [[nodiscard]] Vector given(std::int32_t corner) const {
    const auto index = static_cast<std::size_t>(indices_[corner]);
    return index < values_.size() ? Vector(values_[index]) : Vector(0.0);
  }
  /// Of a row: values within those that are given.
  [[nodiscard]] Vector row(const Vector& value) const {
    if constexpr (kIsCoordinates) return value;
    return glm::clamp(value, lowest_, highest_);
  }
  /// Control values of a place, in the order of its class's columns, as the corner's face sees
  /// them.
  void columns(const PatchPlace& place, std::int32_t corner, std::vector<std::int32_t>& indices,
               std::vector<Vector>& values) const;

 private:
  // The affine map of a piece: the corners of a chart at a vertex between two sharp edges.
  using Gradient = std::array<Vector, 3>;
  struct Piece {
    std::int32_t vertex = 0;
    std::int32_t fan = 0;  // the first piece at the vertex of the same chart
    glm::dvec3 at{0.0};
    Vector value{0.0};
    Gradient gradient{}, of_fan{};
    std::int32_t curve0 = -1;  // of a crease: the curve point that has value + handle
    Vector handle{0.0};
    [[nodiscard]] Vector map(const glm::dvec3& point) const {
      return value + times(gradient, point - at);
    }
  };
  // Of a face; in the precision of what is given.
  struct Integral {
    using Real = typename Stored::value_type;
    glm::vec<3, Real> normal{0};
    Real area = 0, turn = 0;  // turn: of the values, below 0 where they go around the other way
    std::array<Stored, 3> gradient{};
  };
  struct Around;

  static Vector times(const Gradient& gradient, const glm::dvec3& d) {
    return d.x * gradient[0] + d.y * gradient[1] + d.z * gradient[2];
  }
  [[nodiscard]] bool is_seam(std::int32_t corner, std::int32_t next, bool is_mirrored) const;
  [[nodiscard]] bool is_moved(std::int32_t corner, std::int32_t next) const;
  [[nodiscard]] bool goes_on(std::int32_t corner, std::int32_t next,
                             std::span<const Integral> faces) const;
  static Gradient turned(const Integral& face, const glm::dvec3& normal);
  [[nodiscard]] Integral integral_over(std::int32_t face) const;
  void cut(std::int32_t vertex, std::span<const Integral> faces, Around& around) const;
  void fit(std::span<const Integral> faces, Around& around) const;
  template <class Value, class At>
  [[nodiscard]] Value face_mean(std::int32_t face, const Value& origin, const At& at) const;
  void find_handles(std::int32_t vertex, std::span<const glm::dvec3> points, Around& around) const;
  void shrink(std::span<const glm::dvec3> points, std::span<const Integral> faces,
              Around& around) const;
  void shrink_to_faces(std::span<const glm::dvec3> points, std::span<const Integral> faces,
                       Around& around) const requires kIsCoordinates;
  [[nodiscard]] Vector along_edges(std::int32_t corner, const glm::dvec3& step) const;
  void shrink_to_ranges(std::span<const glm::dvec3> points, Around& around) const
      requires(!kIsCoordinates);
  void write_own(std::int32_t vertex, std::span<const glm::dvec3> points, const Around& around);
  [[nodiscard]] std::int32_t curve_at(std::int32_t vertex, std::int32_t edge) const;
  template <class FanOf>
  [[nodiscard]] Vector curve_value(const Piece& piece, std::int32_t curve, const glm::dvec3& point,
                                   const FanOf& fan_of) const;
  [[nodiscard]] Vector on_piece(std::int32_t piece, std::int32_t point) const;
  [[nodiscard]] Vector sum_on_piece(std::int32_t piece, std::int32_t sum) const;
  [[nodiscard]] Vector column(std::int32_t point, std::int32_t corner) const;
  void add_sums();

  const PatchMesh& mesh_;
  const MeshTopology& topology_;
  std::span<const std::int32_t> indices_;
  std::span<const Stored> values_;
  std::array<int, 4> attributes_;
  Vector lowest_{0.0}, highest_{0.0};
  std::vector<std::int32_t> edge_of_sharp_;
  RawVector<Stored> own_;
  // Of vertices at seams; empty where there is none.
  RawVector<std::int32_t> piece_of_corner_;  // -1: no seam at the vertex
  std::vector<Piece> pieces_;
  RawVector<glm::dvec3> limits_, points_;
};

/// Rows of a field at a level.
template <class Vector>
class ChartRows {
 public:
  ChartRows(const ChartField<Vector>& field, const PatchNumbering& numbering,
            const PatchClasses& classes)
      : field_(field), numbering_(numbering), classes_(classes) {}

  /// result(row, value) for each row of the range that lies behind those of the vertices.
  template <class Result>
  void write(RowRange range, const Result& result) {
    using Part = PatchNumbering::Part;
    for (const Part part :
         {Part::Faces, Part::Edges, Part::Corners, Part::Trailing, Part::Further}) {
      const std::int64_t begin = std::max(range.first, numbering_.first_row(part));
      const std::int64_t end = std::min(range.first + range.count, numbering_.end_row(part));
      if (begin >= end) continue;
      if (part == Part::Corners) {
        write_corners(begin, end, result);
      } else {
        for (std::int64_t row = begin; row < end; ++row) result(row, value(part, row));
      }
    }
  }

 private:
  [[nodiscard]] Vector value(PatchNumbering::Part part, std::int64_t row) {
    using Part = PatchNumbering::Part;
    const PatchMesh& mesh = field_.mesh();
    const std::int64_t item = row - numbering_.first_row(part);
    if (part == Part::Trailing) {
      const std::int32_t count = numbering_.samples().trailing_count();
      take_corner(numbering_.item_corner(part, item / count));
      return at(numbering_.samples().first_trailing() + static_cast<std::int32_t>(item % count));
    }
    const std::int32_t corner = numbering_.item_corner(part, item);
    if (part == Part::Faces)
      take(mesh.face_point(mesh.topology().face_of(corner)), corner);
    else if (part == Part::Edges || numbering_.is_further_edge(item))
      take(mesh.edge_point(corner), corner);
    else
      return field_.given(corner);
    return at(0);
  }

  template <class Result>
  void write_corners(std::int64_t begin, std::int64_t end, const Result& result) {
    for (std::int32_t c = numbering_.corner_of_row(begin); begin < end; ++c) {
      const std::int64_t first = numbering_.corner_row(c);
      const std::int64_t last = std::min(end, first + numbering_.corner_row_count(c));
      if (begin >= last) continue;
      take_corner(c);
      for (; begin < last; ++begin) result(begin, at(static_cast<std::int32_t>(begin - first)));
    }
  }

  void take_corner(std::int32_t corner) { take(field_.mesh().corner_patch(corner), corner); }
  void take(const PatchPlace& place, std::int32_t corner) {
    const PatchClass& patch = place.patch;
    const bool is_even =
        patch.kind == PatchKind::Smooth && !patch.has_ring_sums && !patch.has_face_sums;
    std::int32_t index = is_even ? classes_.smooth_index(patch.ring_size, patch.face_size) : -1;
    if (index < 0) index = classes_.index_of(patch);
    weights_ = &classes_.weights(index);
    field_.columns(place, corner, indices_, values_);
    for (std::size_t k = 1; k < values_.size(); ++k) values_[k] -= values_[0];
  }
  [[nodiscard]] Vector at(std::int32_t sample) const {
    const std::span<const double> weights = weights_->rows(sample);
    Vector sum = values_[0];
    for (std::size_t k = 1; k < values_.size(); ++k) sum += weights[k - 1] * values_[k];
    return field_.row(sum);
  }

  const ChartField<Vector>& field_;
  const PatchNumbering& numbering_;
  const PatchClasses& classes_;
  const PatchTemplate* weights_ = nullptr;
  std::vector<std::int32_t> indices_;
  std::vector<Vector> values_;
};

}  // namespace planish
