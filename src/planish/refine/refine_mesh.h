#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"
#include "planish/refine/even_triangles.h"

namespace planish {

/// Whether vertices are put between those of uneven triangles; auto: where the surface is better.
enum class RefineChoice { Auto, On, Off };

/// A vertex that was added, as a mean of three given ones.
struct AddedVertex {
  std::array<std::int32_t, 3> vertices;
  glm::dvec3 weights;  ///< their sum is 1
  double doubt = 0;    ///< the share of the heights around that the guess does not tell, 0 to 1
};

/// A mesh with vertices added by make_even_triangles().
struct RefinedMesh {
  /// The given vertices come first, where they were; tags, groups, holes, texture coordinates,
  /// colours and attributes are those of the given faces.
  PolygonMesh mesh;
  std::vector<std::int32_t> source_faces;  ///< of each face: a given one of its part of the mesh
  /// The last vertices of the mesh, each by the corners of the given face that it lies over.
  std::vector<AddedVertex> added;
};

/// Adds vertices to a mesh of triangles, into which larger polygons are cut; its tagged edges,
/// borders of groups and holes, and seams of texture coordinates stay lines. Empty where half the
/// faces and more are quads, whose rings are even, where polygons cannot be cut without an edge of
/// three faces, or where none would be added. `prepared` is of `mesh`.
[[nodiscard]] std::optional<RefinedMesh> refine_mesh(const PolygonMesh& mesh,
                                                     const PreparedMesh& prepared);

/// How much the faces of a mesh turn at its edges that are no creases, in degrees: root of the mean
/// square by length.
[[nodiscard]] double rms_turn(const PolygonMesh& mesh, const PreparedMesh& prepared);

}  // namespace planish
