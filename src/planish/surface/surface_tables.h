#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/stencil/sector_rows.h"
#include "planish/stencil/stencil_builder.h"
#include "planish/stencil/stencil_table.h"
#include "planish/surface/evaluate.h"

namespace planish {

/// A primal scheme on one mesh down to one level, as a chain of stencil tables: control points
/// -> state of level 1 -> ... -> state of state_level() -> limit points and tangents. Tables are
/// made in slices of rows.
class SurfaceTables {
 public:
  virtual ~SurfaceTables() = default;

  /// The level whose state gives the output's limit points: the output's, but at least 1.
  [[nodiscard]] virtual int state_level() const = 0;
  [[nodiscard]] virtual std::int64_t state_size(int level) const = 0;
  /// Rows of the state of `level` >= 1 from that of level - 1, the control points for level 1.
  [[nodiscard]] virtual StencilTable<double> step(int level, RowRange rows) const = 0;

  /// The output's vertices.
  [[nodiscard]] virtual const SectorRows& rows() const = 0;
  [[nodiscard]] virtual LimitStencilTable<double> limit(RowRange rows) const = 0;
  /// The corners of the output's faces, one face after another. From level 1 on all faces have
  /// corners_per_face() of them.
  [[nodiscard]] virtual std::vector<std::int32_t> face_vertices() const = 0;
  [[nodiscard]] virtual int corners_per_face() const = 0;

  /// The topology of the output, which is its level `level`.
  [[nodiscard]] virtual const OpenSubdiv::Far::TopologyRefiner& refiner() const = 0;
};

/// Throws Error{UnusableMesh} for Loop on other
/// faces than triangles and Error{OutOfMemory} before memory is taken.
[[nodiscard]] std::unique_ptr<SurfaceTables> primal_tables(const UsedPart& used,
                                                           PrimalScheme scheme,
                                                           const EvaluateOptions& options);

}  // namespace planish
