#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/core/raw_vector.h"
#include "planish/fair/fair_halo.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// The bending of a net of level 1, linearised in one height per control point along the normal of
/// its vertex: the sum of all squares of (value + coefficients . heights), two lines per corner.
/// Control points that must stay (around crease and corner vertices) have zero coefficients.
struct BendingRows {
  /// The two lines through the control point of one corner: from the next corner of its face
  /// through it to the one after it around the vertex, and from the previous corner through it to
  /// the one before. The coefficients of those heights.
  struct Row {
    float next, own1, after;
    float previous, own2, before;
  };
  /// What the two lines of one corner, multiplied by the transposed rows, give to heights: to the
  /// corner's own, together with the lines beside it in the face, and to the ones after and before
  /// it around the vertex.
  struct Product {
    float face, after, before;
  };
  RawVector<Row> rows;          ///< per corner
  RawVector<Product> products;  ///< per corner: of the values, half the gradient at heights 0
  /// Per vertex: 1 / mean diagonal of the Hessian over its heights; 0 where they must stay.
  RawVector<float> preconditioner;
  double value_square = 0;  ///< sum of the squares of the values: the bending at heights 0
};

/// `offsets`: the state of level 1 relative to the given points; `directions`: those in which
/// heights move the control points, per vertex. In single precision, which coordinates near unit
/// diagonal suit. A line one of whose two parts is too short to measure bending on counts for
/// nothing. `halo`: where the mesh is a part, whose value_square is its own.
[[nodiscard]] BendingRows make_bending_rows(const FairTopology& topology,
                                            std::span<const glm::dvec3> given,
                                            std::span<const glm::dvec3> directions,
                                            std::span<const glm::dvec3> offsets,
                                            FairHalo* halo = nullptr);

/// The product of one corner from the lines through it and through its face's neighbours.
struct BendingLines {
  float line1, line2;
};
[[nodiscard]] inline BendingRows::Product transposed_product(const BendingRows::Row& own,
                                                             const BendingLines& own_lines,
                                                             const BendingRows::Row& previous,
                                                             const BendingLines& previous_lines,
                                                             const BendingRows::Row& next,
                                                             const BendingLines& next_lines) {
  return {own.own1 * own_lines.line1 + own.own2 * own_lines.line2 +
              previous.next * previous_lines.line1 + next.previous * next_lines.line2,
          own.after * own_lines.line1, own.before * own_lines.line2};
}

}  // namespace planish
