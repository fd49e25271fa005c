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
#include "planish/files/gltf/triangulate.h"
#include "planish/files/shared/ordered_stream.h"
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

 private:
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
