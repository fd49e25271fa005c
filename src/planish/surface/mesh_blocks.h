#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
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
    copy(surface_.face_vertices, corner_range(faces), rows);
  }
  void face_uvs(RowRange faces, std::span<std::int32_t> uvs) const override {
    copy(surface_.face_uvs, corner_range(faces), uvs);
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
  [[nodiscard]] RowRange corner_range(RowRange faces) const {
    const std::int64_t first = info_.first_corner(faces.first);
    return {first, info_.first_corner(faces.first + faces.count) - first};
  }

  const SurfaceMesh& surface_;
  std::span<const std::int32_t> given_faces_;
  std::vector<std::int32_t> mesh_faces_;  // else visible ones
  std::vector<std::int64_t> ends_;        // of their descendants
};

/// Some of the numbers from 0 to `limit`, and their places among these, ascending.
class SubsetNumbers {
 public:
  SubsetNumbers() = default;
  explicit SubsetNumbers(std::int64_t limit);
  /// From any number of threads.
  void add(std::span<const std::int32_t> numbers);
  /// When all are there.
  void finish();

  [[nodiscard]] std::span<const std::int32_t> all() const { return numbers_; }
  /// How many are smaller: the place of one of them.
  [[nodiscard]] std::int32_t place_of(std::int32_t number) const;

 private:
  std::vector<std::uint64_t> marks_;  // a bit for each number
  RawVector<std::int32_t> before_;    // of each word of marks_: how many come before it
  RawVector<std::int32_t> numbers_;
};

/// Some faces of a surface, one behind another, as a surface of their own: its rows are those that
/// the faces name, in their order, so that given vertices stay first; texture coordinates likewise.
/// Both have the bits that they have in the surface, which must outlive this. Takes 4 bytes a row
/// of its own, and a bit for each of the surface's.
class FaceRangeBlocks final : public SurfaceBlocks {
 public:
  FaceRangeBlocks(const SurfaceBlocks& surface, RowRange faces);

  /// The surface's row of each row, ascending.
  [[nodiscard]] std::span<const std::int32_t> surface_rows() const { return rows_.all(); }
  /// Of each texture coordinate the same.
  [[nodiscard]] std::span<const std::int32_t> surface_uvs() const { return uvs_.all(); }

  [[nodiscard]] std::vector<RowRange> row_blocks(std::int64_t row_count) const override;
  /// What it returns has the surface's numbers.
  DegenerateRows rows(RowRange rows, const RowTarget& target) const override;
  void face_vertices(RowRange faces, std::span<std::int32_t> rows) const override;
  void face_uvs(RowRange faces, std::span<std::int32_t> uvs) const override;
  void face_groups(RowRange faces, std::span<std::int32_t> groups) const override {
    surface_.face_groups(there(faces), groups);
  }
  void ancestors(RowRange faces, std::span<std::int32_t> mesh_faces) const override {
    surface_.ancestors(there(faces), mesh_faces);
  }
  void attribute(std::size_t index, RowRange rows, std::span<float> values) const override;
  void uvs(RowRange uvs, std::span<glm::dvec2> values) const override;
  void corners(RowRange faces, std::span<glm::dvec3> positions,
               std::span<glm::vec3> normals) const override {
    surface_.corners(there(faces), positions, normals);
  }
  void cuts(RowRange faces, std::span<std::uint8_t> from_1) const override {
    surface_.cuts(there(faces), from_1);
  }

 private:
  [[nodiscard]] RowRange there(RowRange faces) const {
    return {faces_.first + faces.first, faces.count};
  }
  [[nodiscard]] static std::span<const std::int32_t> part(const SubsetNumbers& numbers,
                                                          RowRange range) {
    return numbers.all().subspan(static_cast<std::size_t>(range.first),
                                 static_cast<std::size_t>(range.count));
  }
  void find_numbers();

  const SurfaceBlocks& surface_;
  RowRange faces_;
  SubsetNumbers rows_, uvs_;
};

}  // namespace planish
