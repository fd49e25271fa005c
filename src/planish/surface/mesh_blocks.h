#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/surface/surface_blocks.h"

namespace planish {

/// A surface that stands in memory, as blocks; see blocks_of().
class MeshBlocks : public SurfaceBlocks {
 public:
  /// A level of a surface of `mesh`.
  MeshBlocks(const SurfaceMesh& surface, const PolygonMesh& mesh);
  /// Any other tessellation: `mesh_faces` has the mesh's face of each face.
  MeshBlocks(const SurfaceMesh& surface, std::span<const std::int32_t> mesh_faces);

  [[nodiscard]] std::vector<RowRange> row_blocks(std::int64_t row_count) const override {
    return ranges_of(info_.row_count, row_count);
  }
  DegenerateRows rows(RowRange rows, const RowTarget& target) const override;
  void face_vertices(RowRange faces, std::span<std::int32_t> rows) const override {
    copy(surface_.face_vertices, corners_of(faces), rows);
  }
  void face_uvs(RowRange faces, std::span<std::int32_t> uvs) const override {
    copy(surface_.face_uvs, corners_of(faces), uvs);
  }
  void face_groups(RowRange faces, std::span<std::int32_t> groups) const override {
    copy(surface_.face_groups, faces, groups);
  }
  void ancestors(RowRange faces, std::span<std::int32_t> mesh_faces) const override;
  void attribute(std::size_t index, RowRange rows, std::span<float> values) const override;
  void uvs(RowRange uvs, std::span<glm::dvec2> values) const override {
    copy(surface_.uvs, uvs, values);
  }
  void corners(RowRange faces, std::span<glm::dvec3> positions,
               std::span<glm::vec3> normals) const override;

 private:
  explicit MeshBlocks(const SurfaceMesh& surface);
  template <class Values, class T>
  static void copy(const Values& from, RowRange range, std::span<T> to) {
    if (!to.empty()) std::copy_n(from.begin() + range.first, range.count, to.begin());
  }
  [[nodiscard]] RowRange corners_of(RowRange faces) const {
    const std::int64_t first = info_.first_corner(faces.first);
    return {first, info_.first_corner(faces.first + faces.count) - first};
  }

  const SurfaceMesh& surface_;
  std::span<const std::int32_t> given_faces_;
  std::vector<std::int32_t> mesh_faces_;  // else visible ones
  std::vector<std::int64_t> ends_;        // of their descendants
};

}  // namespace planish
