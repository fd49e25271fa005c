#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "planish/core/range.h"
#include "planish/mesh/prepared_mesh.h"
#include "planish/primal/primal_split.h"
#include "planish/stencil/sector_rows.h"
#include "planish/stencil/stencil_table.h"
#include "planish/surface/evaluate.h"

namespace planish {

struct VertexStar;

/// A primal scheme on one mesh down to one level, as a chain of stencil tables: control points
/// -> state of level 1 -> ... -> state of state_level() -> limit points and tangents. Tables are
/// made in slices of rows.
class PrimalTables {
 public:
  /// Throws Error{UnusableMesh} for Loop on other faces than triangles and Error{OutOfMemory}
  /// before memory is taken.
  PrimalTables(const UsedPart& used, PrimalScheme scheme, const EvaluateOptions& options);

  /// The level whose state gives the output's limit points: the output's, but at least 1.
  [[nodiscard]] int state_level() const { return std::max(level_, 1); }
  [[nodiscard]] std::int64_t state_size(int level) const {
    return split_.level(level).GetNumVertices();
  }
  /// Rows of the state of `level` >= 1 from that of level - 1, the control points for level 1.
  [[nodiscard]] StencilTable step(int level, RowRange rows) const;

  /// The output's vertices.
  [[nodiscard]] const SectorRows& rows() const { return rows_; }
  [[nodiscard]] StencilTable limit(RowRange rows) const;
  /// The corners of the output's faces, one face after another. From level 1 on all faces have
  /// corners_per_face() of them.
  [[nodiscard]] std::vector<std::int32_t> face_vertices() const;
  [[nodiscard]] int corners_per_face() const {
    return split_.scheme() == PrimalScheme::Loop ? 3 : 4;
  }

  /// The topology of the output, which is its level `level`.
  [[nodiscard]] const OpenSubdiv::Far::TopologyRefiner& refiner() const { return split_.refiner(); }

 private:
  [[nodiscard]] std::int32_t row_of(std::int32_t face, int corner, std::int32_t vertex,
                                    VertexStar& star) const;

  int level_;
  PrimalSplit split_;
  SectorRows rows_;
};

}  // namespace planish
