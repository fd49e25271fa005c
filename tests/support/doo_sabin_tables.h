#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/patches/patch_plan.h"
#include "planish/solve/stencil_builder.h"
#include "planish/solve/stencil_table.h"
#include "support/opensubdiv_topology.h"

// Doo-Sabin surfaces as a chain of stencil tables from control points down to the limit points of a
// level, on OpenSubdiv's topology of that level: what surfaces of patches are held against.
namespace planish::test {

/// A subdivision with the levels behind the first, as many as the split has, which must outlive it.
///
/// The state of level l >= 1 is as that of level 1 (see Subdivision), with a control point per face
/// of Q_l. Child `end` (0 or 1, the end's place in the edge) of sharp edge s has number 2 s + end.
class SubdivisionChain : public Subdivision {
 public:
  SubdivisionChain(const QuadSplit& split, const SharpFeatures& features, Weights weights);

  [[nodiscard]] const QuadSplit& split() const { return split_; }

  /// Number of an edge of Q_level among the sharp edges of that level, or -1.
  [[nodiscard]] std::int32_t sharp_of(int level, std::int32_t edge) const {
    return has_sharp_edges() ? sharp_of_edge_[level][edge] : -1;
  }
  /// The edge of Q_level with that number among the sharp.
  [[nodiscard]] std::int32_t edge_of(int level, std::int32_t sharp) const {
    return edge_of_sharp_[level][sharp];
  }

  /// Where the parts of a level's state begin.
  struct StateLayout {
    std::int64_t first_sharp, first_corner, size;
  };
  /// Level 1 to one more than the split has.
  [[nodiscard]] const StateLayout& state_layout(int level) const { return layouts_[level]; }

 private:
  const QuadSplit& split_;
  std::vector<StateLayout> layouts_;
  std::vector<std::vector<std::int32_t>> sharp_of_edge_, edge_of_sharp_;  // per level
};

/// The ring of a vertex of Q_level in the state of that level. Needs full topology of level - 1.
void gather_ring(const SubdivisionChain& subdivision, int level, std::int32_t vertex,
                 VertexRing& ring);

/// From the state of level - 1, or control points, to that of `level` >= 1.
[[nodiscard]] StencilTable step_table(const SubdivisionChain& subdivision, int level,
                                      RowRange rows);
/// All its rows.
[[nodiscard]] StencilTable step_table(const SubdivisionChain& subdivision, int level);

/// The output vertices of Q_level.
class LimitRows {
 public:
  using Place = SectorRows::Place;

  LimitRows(const SubdivisionChain& subdivision, int level);

  /// The level whose state gives the limit points: at least 1.
  [[nodiscard]] int state_level() const { return state_level_; }
  [[nodiscard]] std::int64_t count() const { return sectors_.count(); }
  [[nodiscard]] Place place(std::int64_t row) const { return sectors_.place(row); }
  /// The row of `vertex` as seen from face `face` of the state's level.
  [[nodiscard]] std::int32_t row_of(std::int32_t vertex, std::int32_t face,
                                    VertexRing& scratch) const;
  /// The rows in the numbering of patches of the level without hidden faces: entry i is row i's
  /// number here.
  [[nodiscard]] std::vector<std::int32_t> in_order_of(const PatchNumbering& numbering) const;

 private:
  const SubdivisionChain& subdivision_;
  int state_level_;
  SectorRows sectors_;
};

/// Limit points, with du and dv whose cross product is the outward normal's direction, of rows of
/// `limit_rows`, from the state of its level. Source: mathematics of Doo-Sabin limit tangents: the
/// first Fourier pair of the polygon around a vertex.
[[nodiscard]] StencilTable limit_table(const SubdivisionChain& subdivision,
                                       const LimitRows& limit_rows, RowRange rows);
[[nodiscard]] StencilTable limit_table(const SubdivisionChain& subdivision,
                                       const LimitRows& limit_rows);
/// Of rows in any order, by their numbers in `limit_rows`.
[[nodiscard]] StencilTable limit_table(const SubdivisionChain& subdivision,
                                       const LimitRows& limit_rows,
                                       std::span<const std::int32_t> order);

/// A mesh with its chain of tables down to a level.
struct ChainCase {
  ChainCase(const PolygonMesh& given, Weights weights, int levels,
            const SharpFeatureOptions& sharp = {});
  ChainCase(const ChainCase&) = delete;
  ChainCase& operator=(const ChainCase&) = delete;

  PolygonMesh mesh;
  QuadSplit split;
  SharpFeatures features;
  SubdivisionChain subdivision;
};

/// The table's rows of points.
[[nodiscard]] std::vector<glm::dvec3> applied(const StencilTable& table,
                                              std::span<const glm::dvec3> source);

}  // namespace planish::test
