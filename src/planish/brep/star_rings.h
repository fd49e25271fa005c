#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "planish/brep/square_piece.h"
#include "planish/primal/star_limit.h"
#include "planish/primal/vertex_star.h"

namespace planish {

/// Catmull-Clark around one vertex, halving by halving. Faces follow one another counter-clockwise;
/// a place in one is (x, y) from the vertex along the face's first edge and along its second, which
/// is the first of the next face.
class StarRings {
 public:
  /// Points (a, b) at a + 4 b, a and b from 0 to 3.
  using Grid = std::array<glm::dvec3, 16>;

  /// `star`: its sharpness is infinite or none, and beyond its faces all is regular. `grids`: by
  /// face its points with a and b to 2.
  void set(const VertexStar& star, std::vector<Grid> grids);

  [[nodiscard]] const glm::dvec3& limit() const { return limit_; }
  /// Of the limit in a face; not of unit length.
  [[nodiscard]] glm::dvec3 limit_normal(std::int32_t face);
  /// Bezier points of the surface on [x, x + 1] x [y, y + 1], x and y 0 or 1, but not [0, 1]^2, in
  /// steps of the grids after so many halvings, at least 1.
  [[nodiscard]] PointNet square(int halvings, std::int32_t face, int x, int y);

 private:
  void halve();
  [[nodiscard]] glm::dvec3 next_vertex(const std::vector<Grid>& grids) const;
  [[nodiscard]] bool is_sharp(std::size_t edge) const;
  [[nodiscard]] std::size_t face_after(std::size_t face) const {
    return face + 1 == levels_.front().size() ? 0 : face + 1;
  }
  [[nodiscard]] std::size_t face_before(std::size_t face) const {
    return (face == 0 ? levels_.front().size() : face) - 1;
  }
  [[nodiscard]] std::size_t edge_after(std::size_t face) const {
    return star_.is_boundary() ? face + 1 : face_after(face);
  }
  [[nodiscard]] glm::dvec3 weighted(const StarWeights& weights) const;

  VertexStar star_;
  SubdivisionMask mask_;  // of the vertex
  StarLimits limits_{PrimalScheme::CatmullClark};
  glm::dvec3 limit_{};
  std::vector<std::vector<Grid>> levels_;  // by halvings and face
};

}  // namespace planish
