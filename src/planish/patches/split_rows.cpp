#include "planish/patches/split_rows.h"

#include "planish/doosabin/vertex_ring.h"

namespace planish {

std::vector<std::int32_t> limits_of_rows(const MeshTopology& topology,
                                         const PatchNumbering& numbering, const QuadSplit& split,
                                         const LimitRows& limits) {
  std::vector<std::int32_t> rows(static_cast<std::size_t>(numbering.row_count()), -1);
  VertexRing ring;
  if (numbering.level() == 0) {
    for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
      rows[numbering.vertex_row(c)] = limits.row_of(topology.vertex_of(c), c, ring);
    }
    return rows;
  }
  const auto& level = split.level(numbering.level());
  const PatchCells cells(numbering.level());
  const std::int32_t side = numbering.samples().side() + 1;
  std::vector<std::int32_t> grid(static_cast<std::size_t>(side * side));
  std::int32_t face = 0;
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
    numbering.grid(c, grid.data());
    for (const auto& cell : cells.of(topology, c)) {
      const auto vertices = level.GetFaceVertices(face);
      for (int k = 0; k < 4; ++k) rows[grid[cell[k]]] = limits.row_of(vertices[k], face, ring);
      ++face;
    }
  }
  return rows;
}

}  // namespace planish
