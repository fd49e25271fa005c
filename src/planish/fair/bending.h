#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_net.h"
#include "planish/fair/fair_topology.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// Calls body(begin, end) for pieces of [0, count) on all threads and sums what it returns;
/// `make_body` makes one for each piece. Pieces are of fixed size: the same bits for every
/// thread count.
template <class MakeBody>
double piecewise_sum_of_ranges(std::int32_t count, const MakeBody& make_body) {
  const auto of_range = [&](std::size_t begin, std::size_t end) -> double {
    return make_body()(static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end));
  };
  return ordered_reduce(static_cast<std::size_t>(count), 4096, 0.0, of_range,
                        [](double& sum, double piece) { sum += piece; });
}

/// The same of body(i) for i in [0, count).
template <class MakeBody>
double piecewise_sum(std::int32_t count, const MakeBody& make_body) {
  return piecewise_sum_of_ranges(count, [&] {
    return [body = make_body()](std::int32_t begin, std::int32_t end) mutable {
      double sum = 0;
      for (std::int32_t i = begin; i < end; ++i) sum += body(i);
      return sum;
    };
  });
}

/// body(first corner, size of the face), the size as a constant of its type for triangles and quads
/// so that loops over it unroll.
template <class Body>
double for_face_size(const FairTopology& topology, std::int32_t face, const Body& body) {
  const std::int32_t first = topology.face_offsets[face];
  const std::int32_t m = topology.face_size(face);
  if (m == 3) return body(first, std::integral_constant<std::int32_t, 3>{});
  if (m == 4) return body(first, std::integral_constant<std::int32_t, 4>{});
  return body(first, m);
}

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

/// The vector by which a height of 1 moves the control points around each vertex: its normal, but 0
/// where they must stay, around vertices without a polygon or in a plane that is kept. Control
/// points of the tensor-product construction, a part `shares` of each vertex, stay as well near
/// curves: less bending between curves that cannot move is not more accuracy there.
[[nodiscard]] std::vector<glm::dvec3> polish_directions(const FairTopology& topology,
                                                        std::span<const glm::dvec3> normals,
                                                        std::span<const double> shares,
                                                        const PlanePlaces& planes = {});

/// Heights, one per place of the ring arrays, that lower the bending: `steps` steps of conjugate
/// gradients from 0 on the heights whose sum over each polygon is 0. The same bits for every thread
/// count. `bending` is used up. `halo`: where the mesh is a part.
[[nodiscard]] RawVector<float> polish_heights(const FairTopology& topology, BendingRows&& bending,
                                              std::int32_t steps, FairHalo* halo = nullptr);

/// Moves the control points in `offsets` by heights along the directions, those of each polygon
/// scaled so that none moves by more than 0.3 of its distance to the vertex: beyond that the
/// linearised bending is not to be trusted.
void apply_heights(const FairTopology& topology, std::span<const glm::dvec3> directions,
                   std::span<const float> heights, std::span<glm::dvec3> offsets);

/// The bending of a mesh as a sum of squares over its vertices, in flat arrays that a device can
/// take as they are. The row of a smooth vertex v is its mean curvature, from the height over its
/// tangent plane of the vertices beside it,
///   r_v = n_v . sum_j own_vj (x_j - x_v),   bending = sum_v r_v^2 / area_v,
/// that of a vertex on a sharp curve the curve's curvature, a vector at right angles to the curve,
/// from the two neighbours along it. Corner vertices have none.
struct BendingTable {
  struct Entry {
    std::int32_t vertex;  ///< beside the row's
    float own;            ///< its weight in this row
    float theirs;         ///< this row's vertex's weight in its row
  };
  RawVector<std::int32_t> offsets;  ///< vertex_count + 1: entries of each row, counter-clockwise
  RawVector<Entry> entries;
  RawVector<float> inverse_areas;  ///< 1 / area_v: half of sum_j own_vj |x_j - x_v|^2
  /// A step by this times the gradient never raises the bending: the reciprocal of the sum of what
  /// is in the row of the Hessian, without signs.
  RawVector<float> steps;
  std::vector<std::uint8_t> kinds;      ///< VertexKind
  std::vector<std::uint8_t> is_closed;  ///< faces go all the way round the vertex

  [[nodiscard]] std::int32_t vertex_count() const {
    return static_cast<std::int32_t>(kinds.size());
  }
  [[nodiscard]] std::span<const Entry> row(std::int32_t vertex) const {
    return std::span(entries).subspan(
        static_cast<std::size_t>(offsets[vertex]),
        static_cast<std::size_t>(offsets[vertex + 1] - offsets[vertex]));
  }
};

/// Weights by the lengths of edges and of their duals, from the faces' centroids to the middle of
/// the edge: positive on every mesh, those of finite elements on squares and equilateral triangles.
/// `given` are positions near unit diagonal, of the mesh that `topology` and `features` are of.
[[nodiscard]] BendingTable make_bending_table(const MeshTopology& topology,
                                              const SharpFeatures& features,
                                              std::span<const glm::dvec3> given);

/// Steps of least_bending_moves(): more change the result by less than a hundredth of the bound.
inline constexpr int kLeastBendingSteps = 30;
/// How much of each step the momentum repeats.
[[nodiscard]] std::array<double, kLeastBendingSteps> nesterov_momenta();

/// Where vertices go so that the mesh bends least.
struct LeastBending {
  std::vector<glm::dvec3> moves;  ///< one per vertex, none longer than the bound
  double bending_before = 0, bending_after = 0;
};

/// Moves smooth vertices along their normals and vertices on sharp curves at right angles to the
/// curve, none by more than `bound`; corner vertices stay. The bending is convex in the moves; it
/// is lowered by kLeastBendingSteps projected gradient steps with Nesterov's momentum (Beck &
/// Teboulle 2009). The same bits for every thread count.
[[nodiscard]] LeastBending least_bending_moves(const BendingTable& table,
                                               std::span<const glm::dvec3> given, double bound,
                                               FairHalo* halo = nullptr);

/// As wanted; empty: kNoiseBound of measured_noise(). Throws Error{InvalidArgument}.
[[nodiscard]] LeaveWithin leave_within(const std::optional<double>& wanted,
                                       const BendingTable& table,
                                       std::span<const glm::dvec3> given);

/// The standard deviation of noise along the normals that explains how unevenly the mesh bends: the
/// median over smooth vertices of the fourth difference around each, beside what noise of known
/// size gives there. Shapes that bend within an edge or two count as noise, too. 0 where fewer than
/// 50 vertices lie off sharp curves.
[[nodiscard]] double measured_noise(const BendingTable& table, std::span<const glm::dvec3> given);

}  // namespace planish
