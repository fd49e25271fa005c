#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/patches/patch_plan.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish {

/// The rows of level 1 that some faces of the mesh need: of their vertices, centres and midpoints
/// of edges, each once where faces that share it are added one after another in the order of the
/// mesh. Topology and numbering must outlive it.
class SharedPoints {
 public:
  /// Room for faces of so many corners together.
  SharedPoints(const MeshTopology& topology, const PatchNumbering& numbering,
               std::int64_t corner_count);

  /// Adds a visible face. What was added before one that does not follow it is no longer shared.
  void add_face(std::int32_t face);

  /// All of them.
  [[nodiscard]] std::span<const std::int32_t> rows() const { return {rows_.data(), row_count_}; }
  /// Places in rows(), of corners of the last face: their vertex, the midpoint of the leading edge.
  [[nodiscard]] std::int32_t vertex(std::int32_t corner) const {
    return vertices_[corner - begin_];
  }
  [[nodiscard]] std::int32_t midpoint(std::int32_t corner) const {
    return midpoints_[corner - begin_];
  }
  /// Of the last face's centre.
  [[nodiscard]] std::int32_t centre() const { return centre_; }

 private:
  [[nodiscard]] std::int32_t add(std::int32_t row) {
    rows_[row_count_] = row;
    return static_cast<std::int32_t>(row_count_++);
  }
  [[nodiscard]] std::int32_t find_or_add(std::int32_t row, std::int32_t place) {
    return place >= 0 && rows_[place] == row ? place : add(row);
  }

  const MeshTopology& topology_;
  const PatchNumbering& numbering_;
  RawVector<std::int32_t> rows_, vertices_, midpoints_;
  std::size_t row_count_ = 0;
  std::int32_t begin_ = 0, end_ = 0;  // the corners whose places are known
  std::int32_t centre_ = -1;
};

/// One level of a surface, made piece by piece by patches, or whole by a device.
class DooSabinBlocks final : public SurfaceBlocks {
 public:
  DooSabinBlocks(const DooSabinSurface& base, int level, PatchEvaluator* evaluator)
      : base_(base),
        topology_(base.topology()),
        surface_(base.patches(),
                 {.level = level, .weights = base.weights(), .hidden = base.hidden()}),
        cells_(std::max(level, 1)) {
    const PatchSamples& samples = surface_.numbering().samples();
    for (std::int32_t b = 0; b <= samples.side(); ++b) {
      for (std::int32_t a = 0; a <= samples.side(); ++a) {
        sample_of_place_.push_back(samples.index(a, b));
      }
    }
    const PolygonMesh& mesh = base.mesh();
    info_.level = level;
    info_.row_count = surface_.numbering().row_count();
    info_.has_colors = !mesh.colors.empty();
    for (const VertexAttribute& attribute : mesh.attributes)
      info_.attributes.push_back({attribute.name, attribute.width});
    info_.has_groups = !mesh.face_groups.empty();
    if (info_.has_groups) info_.groups = mesh.groups;
    take_base_vertices();
    count_faces();
    if (evaluator != nullptr) {
      device_rows_.resize(static_cast<std::size_t>(info_.row_count));
      evaluator->evaluate_patches(surface_, base.state(), device_rows_);
    }
    if (mesh.face_uvs.empty()) return;
    const CornerUvs& uvs = base.corner_uvs();
    uv_numbering_.emplace(topology_, uvs.indices, uvs.count, level, base.hidden());
    info_.uv_count = uv_numbering_->row_count();
  }

  [[nodiscard]] std::vector<RowRange> row_blocks(std::int64_t row_count) const override;
  DegenerateRows rows(RowRange range, const RowTarget& target) const override;
  DegenerateRows rows_at(std::span<const std::int32_t> rows,
                         const RowTarget& target) const override;
  /// The faces that descend from a face of the mesh; none where it is a hole.
  [[nodiscard]] RowRange faces_of(std::int32_t face) const;
  /// How many rows some faces of the mesh have for their own: those of all faces add up to the row
  /// count, from level 1 on. One flag a face.
  [[nodiscard]] std::int64_t rows_of(std::span<const std::uint8_t> is_of) const;
  /// The rows along the leading edge of a visible corner, 2^level + 1 of them, and those of texture
  /// coordinates; from level 1 on.
  void edge_rows(std::int32_t corner, std::vector<std::int32_t>& rows) const;
  void edge_uvs(std::int32_t corner, std::vector<std::int32_t>& uvs) const;
  void face_vertices(RowRange faces, std::span<std::int32_t> rows) const override {
    write_faces(surface_.numbering(), faces, rows);
  }
  void face_uvs(RowRange faces, std::span<std::int32_t> uvs) const override {
    write_faces(*uv_numbering_, faces, uvs);
  }
  void face_groups(RowRange faces, std::span<std::int32_t> groups) const override {
    for (std::int64_t i = 0; i < faces.count; ++i) {
      groups[i] = base_.mesh().face_groups[mesh_face(faces.first + i)];
    }
  }
  void ancestors(RowRange faces, std::span<std::int32_t> mesh_faces) const override {
    for (std::int64_t i = 0; i < faces.count; ++i) mesh_faces[i] = mesh_face(faces.first + i);
  }
  void attribute(std::size_t index, RowRange rows, std::span<float> values) const override;
  void uvs(RowRange range, std::span<glm::dvec2> values) const override;
  bool uvs_of(std::span<const glm::dvec2> given, std::span<glm::dvec2> values) const override;
  bool corners_of(std::span<const glm::vec4> given, std::span<glm::vec4> values) const override;
  bool rows_of(std::span<const glm::vec4> given, std::span<glm::vec4> values) const override;
  void corners(RowRange faces, std::span<glm::dvec3> positions,
               std::span<glm::vec3> normals) const override {
    if (!device_rows_.empty()) return corners_from_device(faces, positions, normals);
    if (level() <= 1) return point_corners(faces, positions, normals);
    (void)quad_corners(faces, positions, normals, {});
  }
  [[nodiscard]] RowRange rows_of_faces() const override {
    const PatchNumbering& numbering = surface_.numbering();
    // Beside hidden faces there are rows that no visible one makes; a device has made them all.
    if (level() < 2 || numbering.has_hidden() || !device_rows_.empty()) return {0, 0};
    const std::int64_t first =
        surface_.makes_points() ? 0 : numbering.first_row(PatchNumbering::Part::Corners);
    return {first, numbering.end_row(PatchNumbering::Part::Corners) - first};
  }
  [[nodiscard]] bool makes_face_rows() const override {
    return device_rows_.empty() && surface_.makes_points();
  }
  DegenerateRows face_rows(RowRange faces, const PatchTarget& all) const override;
  DegenerateRows corners_and_rows(RowRange faces, std::span<glm::dvec3> positions,
                                  std::span<glm::vec3> normals,
                                  const FaceRows& along) const override {
    if (level() <= 1) {
      corners(faces, positions, normals);
      return {};
    }
    return quad_corners(faces, positions, normals, along);
  }

 private:
  // Rows of values of vertices.
  void write_values(const ChartField<glm::dvec4>& field, RowRange range,
                    std::span<glm::vec4> values) const;
  // Rows of texture coordinates, those of the mesh first: with the field that field() gives, which
  // is asked for where others follow.
  template <class Vector, class Stored, class Field>
  void write_corner_rows(std::span<const Stored> given, RowRange range, std::span<Stored> values,
                         const Field& field) const;
  template <class Vector, class Stored, class Field>
  void write_all_corner_rows(std::span<const Stored> given, std::span<Stored> values,
                             const Field& make_field) const;
  void point_corners(RowRange faces, std::span<glm::dvec3> positions,
                     std::span<glm::vec3> normals) const;
  DegenerateRows quad_corners(RowRange faces, std::span<glm::dvec3> positions,
                              std::span<glm::vec3> normals, const FaceRows& along) const;
  void take_base_vertices();
  void count_faces();
  DegenerateRows rows_from_device(RowRange range, const PatchTarget& target) const;
  void corners_from_device(RowRange faces, std::span<glm::dvec3> positions,
                           std::span<glm::vec3> normals) const;
  [[nodiscard]] int level() const { return info_.level; }
  // Cells of a corner's patch.
  [[nodiscard]] std::int64_t cell_count() const {
    const std::int64_t n = surface_.numbering().samples().side();
    return n * n;
  }
  [[nodiscard]] std::int32_t visible_corner(std::int64_t i) const {
    return visible_.empty() ? static_cast<std::int32_t>(i) : visible_[i];
  }
  [[nodiscard]] std::int32_t mesh_face(std::int64_t face) const {
    if (level() == 0) return visible_corner(face);
    return topology_.face_of(visible_corner(face / cell_count()));
  }
  void write_edge(const PatchNumbering& numbering, std::int32_t corner,
                  std::vector<std::int32_t>& rows) const;
  void write_faces(const PatchNumbering& numbering, RowRange faces,
                   std::span<std::int32_t> rows) const;

  const DooSabinSurface& base_;
  const MeshTopology& topology_;
  PatchSurface surface_;
  PatchCells cells_;
  std::vector<std::int32_t> sample_of_place_;
  std::vector<std::int32_t> visible_;  // level 0: faces, else corners; empty: all
  std::optional<PatchNumbering> uv_numbering_;
  RawVector<PatchEvaluator::Row> device_rows_;  // all of them, or none
};

}  // namespace planish
