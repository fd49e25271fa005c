#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/doosabin/sharp_features.h"
#include "planish/fair/fair_halo.h"
#include "planish/fair/leave_within.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

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
