#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <unordered_map>

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

/// Adds one face: add_face(mesh, {0, 1, 2}).
void add_face(PolygonMesh& mesh, std::initializer_list<std::int32_t> vertices);

/// Vertices named by three integers, each made once.
class LatticeVertices {
 public:
  explicit LatticeVertices(PolygonMesh& mesh) : mesh_(mesh) {}
  /// The vertex at this lattice point; made at `position` on first use.
  std::int32_t at(const std::array<std::int32_t, 3>& point, const glm::dvec3& position);

 private:
  PolygonMesh& mesh_;
  std::unordered_map<std::uint64_t, std::int32_t> vertices_;
};

/// Edge of two vertices as one number, the same from both sides.
[[nodiscard]] std::uint64_t edge_key(std::int32_t a, std::int32_t b);

/// Tags every edge whose two faces' normals differ by more than `degrees`, in face order.
void crease_sharp_edges(PolygonMesh& mesh, double degrees);

/// Newell normal, its length twice the face's area.
[[nodiscard]] glm::dvec3 face_normal(const PolygonMesh& mesh, std::int32_t face);

/// To 1e-6.
[[nodiscard]] double rounded(double number);

/// Rounds every coordinate, those of the texture too, so that a mesh reads the same whatever the
/// last bits of the machine's sine were.
void round_positions(PolygonMesh& mesh);

}  // namespace planish::shapes
