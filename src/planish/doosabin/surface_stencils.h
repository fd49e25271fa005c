#pragma once

#include <cstdint>
#include <span>

#include "planish/doosabin/subdivision.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/stencil/sector_rows.h"
#include "planish/stencil/stencil_builder.h"
#include "planish/stencil/stencil_table.h"

namespace planish {

/// From control points to the state of level 1: one Doo-Sabin step.
[[nodiscard]] StencilTable<double> first_step_table(const PolygonMesh& mesh,
                                                    const Subdivision& subdivision, RowRange rows);

/// From the state of `level` >= 1 to that of level + 1.
[[nodiscard]] StencilTable<double> refinement_table(const Subdivision& subdivision, int level,
                                                    RowRange rows);

/// The output vertices of Q_level, level >= 1.
class LimitRows {
 public:
  using Place = SectorRows::Place;

  LimitRows(const Subdivision& subdivision, int level, std::int64_t vertex_count);

  [[nodiscard]] const SectorRows& sectors() const { return sectors_; }
  [[nodiscard]] std::int64_t count() const { return sectors_.count(); }
  [[nodiscard]] Place place(std::int64_t row) const { return sectors_.place(row); }
  /// The row of `vertex` as seen from face `face` of Q_level.
  [[nodiscard]] std::int32_t row_of(std::int32_t vertex, std::int32_t face,
                                    VertexRing& scratch) const;

 private:
  const Subdivision& subdivision_;
  int level_;
  SectorRows sectors_;
};

/// Limit points, with du and dv whose cross product is the outward normal's direction, of rows of
/// `limit_rows`, from the state of its level. Source: mathematics of Doo-Sabin limit tangents: the
/// first Fourier pair of the polygon around a vertex.
[[nodiscard]] LimitStencilTable<double> limit_table(const Subdivision& subdivision, int level,
                                                    const LimitRows& limit_rows, RowRange rows);
/// The same for rows in any order, by their numbers in `limit_rows`.
[[nodiscard]] LimitStencilTable<double> limit_table(const Subdivision& subdivision, int level,
                                                    const LimitRows& limit_rows,
                                                    std::span<const std::int32_t> order);

}  // namespace planish
