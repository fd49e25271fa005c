#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/refine/even_triangles.h"
#include "planish/refine/vertex_jets.h"

namespace planish {

/// A surface through the vertices of a mesh of triangles, continuous, smooth but for small kinks:
/// over each face the blend of its corners' jets, corrected to the curves along sharp edges.
class GuessSurface {
 public:
  GuessSurface(std::span<const glm::dvec3> positions, const MeshTopology& topology,
               std::span<const char> is_line, std::span<const char> is_sharp);
  [[nodiscard]] glm::dvec3 at(const FacePlace& place) const;
  /// Leaves a face flat from now on.
  void flatten(std::int32_t face) { is_flat_[face] = 1; }
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

}  // namespace planish
