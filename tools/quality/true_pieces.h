#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/reconstruct/triangle_tree.h"

namespace planish::quality {

/// A dense shape, cut where it is sharp, and of each face of a coarse mesh of it the piece that the
/// face was taken from. Beside a sharp edge the nearest place of a shape is often behind the edge:
/// a wall that stands a hair inside its rim would be held against the lid.
class TruePieces {
 public:
  TruePieces(const PolygonMesh& shape, const PolygonMesh& coarse);

  /// Whether a sharp edge of the shape lies between two coarse faces.
  [[nodiscard]] bool are_apart(std::int32_t coarse_face, std::int32_t other) const {
    return of_face_[coarse_face] != of_face_[other];
  }
  /// The normal, of any length, at the nearest place of the piece of a coarse face.
  [[nodiscard]] glm::dvec3 normal(std::int32_t coarse_face, const glm::dvec3& place) const;
  /// To the nearest place of the piece of a coarse face.
  [[nodiscard]] double squared_distance(std::int32_t coarse_face, const glm::dvec3& place) const;

 private:
  struct Piece {
    std::vector<Triangle> triangles;
    TriangleTree tree;
    glm::dvec3 low, high;
  };
  [[nodiscard]] std::int32_t piece_of(std::span<const glm::dvec3> places,
                                      const glm::dvec3& area) const;
  [[nodiscard]] glm::dvec3 normal_at(const Piece& piece, const glm::dvec3& place) const;

  std::vector<glm::dvec3> positions_;
  std::vector<Piece> pieces_;
  std::vector<std::int32_t> of_face_;  // of the coarse mesh
};

}  // namespace planish::quality
