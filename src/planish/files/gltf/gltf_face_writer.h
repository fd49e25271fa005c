#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <numeric>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/mesh/triangulate.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

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
  /// with. Faces of more than four corners are triangles of their own.
  void ngons(RowRange faces, std::int64_t before, RawVector<std::byte>& bytes) {
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
      if (end - begin == 4) {
        to = fan(begin, taken, to);
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

  // The two triangles of a quad at an end of the diagonal that cuts it, one that is not taken.
  Index* fan(std::size_t at, const std::vector<Index>& taken, Index* to) const {
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
