#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"

namespace planish {

/// Cosine of the angle by which faces turn at most where they sample a smooth surface, 60 degrees:
/// nothing is guessed across edges that turn by more, nor is a guess believed that does.
inline constexpr double kLeastSmoothCosine = 0.5;

/// The surface near a vertex as a height over a plane: z = (a x^2 + 2 b x y + c y^2) / 2 + cubic
/// terms, along `normal` over the axes `e1` and `e2`, all in the mesh's unit. (x, y) points to
/// where the place is in the plane, but is as long as the chord to the place itself: so a ball, of
/// which 2 z = c (x^2 + y^2) then, is exact however far it bends away. Passes the vertex.
struct VertexJet {
  glm::dvec3 origin, normal, e1, e2;
  std::array<double, 3> quadric{};  ///< of x^2 / 2, x y, y^2 / 2
  std::array<double, 4> cubic{};    ///< of x^3, x^2 y, x y^2, y^3; 0 where neighbours are few
  /// The share of the heights around that it does not tell of one neighbour from the others, 0 to
  /// 1; its curvature is less by this.
  double doubt = 1;

  /// Where the jet is, along its normal, from a place nearby.
  [[nodiscard]] glm::dvec3 on_jet(const glm::dvec3& place) const;
};

/// One jet a smooth sector of each vertex: sharp edges part what is looked at (see Cazals and
/// Pouget, "Estimating differential quantities using polynomial fitting of osculating jets", 2005).
struct VertexJets {
  std::vector<VertexJet> jets;
  std::vector<std::int32_t> jet_of_corner;  ///< a corner of the topology each
};

/// Least squares over the faces that can be reached by two rings without crossing a sharp edge.
/// `is_sharp`: one per edge; boundaries need not be named. A mesh of triangles.
[[nodiscard]] VertexJets fit_vertex_jets(std::span<const glm::dvec3> positions,
                                         const MeshTopology& topology,
                                         std::span<const char> is_sharp);

}  // namespace planish
