#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "planish/core/range.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/patch_numbering.h"

namespace planish {

/// Corners name values one past the given ones where the mesh has none.
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

/// Values at V, E1, F and E2 of a corner's square, from those at the corners of the mesh.
template <class At>
[[nodiscard]] auto square_values(const MeshTopology& topology, std::int32_t corner, const At& at) {
  const std::int32_t first = topology.first_corner(topology.face_of(corner));
  const std::int32_t m = topology.face_size(topology.face_of(corner));
  auto sum = at(first);
  for (std::int32_t i = 1; i < m; ++i) sum += at(first + i);
  const auto own = at(corner);
  return std::array{own, 0.5 * (own + at(topology.next(corner))), sum / static_cast<double>(m),
                    0.5 * (own + at(topology.prev(corner)))};
}

/// Bilinear between them.
template <class Vector>
[[nodiscard]] Vector bilinear(const std::array<Vector, 4>& square, double u, double v) {
  return (1 - v) * ((1 - u) * square[0] + u * square[1]) +
         v * ((1 - u) * square[3] + u * square[2]);
}

/// Rows of something that is given at the corners of a mesh and linear between them: at centres of
/// faces the mean, at midpoints of edges the mean of two, within each quad of Q_1 bilinear.
/// `at(corner)` is the value at a corner, a vector of doubles. Rows of vertices are left to the
/// caller.
template <class Vector, class At>
class BilinearRows {
 public:
  BilinearRows(const MeshTopology& topology, const PatchNumbering& numbering, const At& at)
      : topology_(topology), numbering_(numbering), at_(at) {}

  /// result(row, value) for each row of the range that lies behind those of the vertices.
  template <class Result>
  void write(RowRange range, const Result& result) const {
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
  [[nodiscard]] Vector mean(std::int32_t face) const {
    Vector sum(0.0);
    const std::int32_t first = topology_.first_corner(face), m = topology_.face_size(face);
    for (std::int32_t c = first; c < first + m; ++c) sum += at_(c);
    return sum / static_cast<double>(m);
  }
  [[nodiscard]] Vector midpoint(std::int32_t corner) const {
    return 0.5 * (at_(corner) + at_(topology_.next(corner)));
  }
  [[nodiscard]] Vector value(PatchNumbering::Part part, std::int64_t row) const {
    using Part = PatchNumbering::Part;
    const std::int64_t item = row - numbering_.first_row(part);
    if (part == Part::Faces) return mean(topology_.face_of(numbering_.item_corner(part, item)));
    if (part == Part::Edges) return midpoint(numbering_.item_corner(part, item));
    if (part == Part::Trailing) {
      const std::int32_t count = numbering_.samples().trailing_count();
      const std::int32_t corner = numbering_.item_corner(part, item / count);
      const double v = static_cast<double>(item % count + 1) / numbering_.samples().side();
      return (1 - v) * at_(corner) + v * midpoint(topology_.prev(corner));
    }
    const std::int32_t corner = numbering_.item_corner(part, item);
    return numbering_.is_further_edge(item) ? midpoint(corner) : at_(corner);
  }

  template <class Result>
  void write_corners(std::int64_t begin, std::int64_t end, const Result& result) const {
    const std::int32_t n = numbering_.samples().side();
    std::int32_t face = -1;
    Vector centre(0.0);
    for (std::int32_t c = numbering_.corner_of_row(begin); begin < end; ++c) {
      const std::int64_t first = numbering_.corner_row(c);
      const std::int64_t last = std::min(end, first + numbering_.corner_row_count(c));
      if (begin >= last) continue;
      if (topology_.face_of(c) != face) {
        face = topology_.face_of(c);
        centre = mean(face);
      }
      const Vector own = at_(c), e1 = midpoint(c), e2 = midpoint(topology_.prev(c));
      for (; begin < last; ++begin) {
        const auto [a, b] = numbering_.samples().place(static_cast<std::int32_t>(begin - first));
        const double u = static_cast<double>(a) / n, v = static_cast<double>(b) / n;
        result(begin, (1 - v) * ((1 - u) * own + u * e1) + v * ((1 - u) * e2 + u * centre));
      }
    }
  }

  const MeshTopology& topology_;
  const PatchNumbering& numbering_;
  const At& at_;
};

}  // namespace planish
