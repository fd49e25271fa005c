#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/refine/refine_mesh.h"

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
  /// Of z^2 / 2, x z and y z where it is a quadric that bends with its height, as ellipsoids and
  /// tubes are, whatever affine map made them thin; (x, y) is the place's foot then.
  std::optional<std::array<double, 3>> implicit;
  /// The share of the heights around that it does not tell of one neighbour from the others, 0 to
  /// 1; its curvature is less by this.
  double doubt = 1;

  /// Where the jet is, along its normal, from a place nearby.
  [[nodiscard]] glm::dvec3 on_jet(const glm::dvec3& place) const;
  /// The unit normal that it foretells at a place of the surface nearby.
  [[nodiscard]] glm::dvec3 normal_at(const glm::dvec3& place) const;
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

/// Marks edges across which no smooth surface can be guessed: faces turn there by more than 60
/// degrees, and the jets of their corners, fitted across, do not foretell one another's normals.
/// `is_sharp`: one per edge; those that are marked already part the jets. A mesh of triangles.
void mark_ridges(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                 std::span<char> is_sharp);

/// A surface through the vertices of a mesh of triangles, continuous, smooth but for small kinks:
/// over each face the blend of its corners' jets, corrected to the curves along sharp edges.
class GuessSurface {
 public:
  GuessSurface(std::span<const glm::dvec3> positions, const MeshTopology& topology,
               std::span<const char> is_line, std::span<const char> is_sharp);
  [[nodiscard]] glm::dvec3 at(const FacePlace& place) const;
  /// Leaves a face flat from now on, or no more.
  void flatten(std::int32_t face, bool is_flat = true) { is_flat_[face] = is_flat ? 1 : 0; }
  /// Whether its three jets leave little in doubt and foretell one another's normals: then they
  /// are believed, however far the guess turns from the face.
  [[nodiscard]] bool is_told(std::int32_t face) const;
  [[nodiscard]] bool is_flat(std::int32_t face) const { return is_flat_[face] != 0; }
  /// Of the jet at a vertex that bends most: a way d along the surface turns its normal by
  /// sqrt(d . turning d) radians.
  [[nodiscard]] glm::dmat3 turning(std::int32_t vertex) const;
  /// Of a corner's jet.
  [[nodiscard]] double doubt(std::int32_t corner) const {
    return jets_.jets[jets_.jet_of_corner[corner]].doubt;
  }

 private:
  std::span<const glm::dvec3> positions_;
  const MeshTopology& topology_;
  VertexJets jets_;
  /// Of each corner whose leading edge is sharp or of the boundary: the curve's directions at its
  /// two ends, of the edge's length; empty where no edge is.
  struct Curve {
    glm::dvec3 begin, end;
  };
  std::vector<std::int32_t> curve_of_corner_;
  std::vector<Curve> curves_;

  std::vector<char> is_flat_;  // faces that the guess leaves flat

  [[nodiscard]] bool is_ridge(std::int32_t corner, std::int32_t twin) const;
  [[nodiscard]] bool turns_too_far(std::int32_t face) const;
  [[nodiscard]] glm::dvec3 face_normal(std::int32_t face) const;
  [[nodiscard]] glm::dvec3 flat_point(const FacePlace& place) const;
  [[nodiscard]] glm::dvec3 blend(const FacePlace& place) const;
  [[nodiscard]] glm::dvec3 curve_point(std::int32_t corner, double share) const;
  void make_curves(std::span<const char> is_line, std::span<const char> is_sharp);
};

/// How densely vertices should lie, one a vertex: an edge e should have e . metric e = 1. Triangles
/// that are narrow all around, as simplification leaves them along a bend, stay so: rings are even
/// up to an affine map, which the surface follows. A mesh of triangles; `guess` is of it.
[[nodiscard]] std::vector<glm::dmat3> spacing_metrics(std::span<const glm::dvec3> positions,
                                                      const MeshTopology& topology,
                                                      const GuessSurface& guess,
                                                      const EvenTrianglesOptions& options);

}  // namespace planish
