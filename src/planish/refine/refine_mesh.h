#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A place of a mesh of triangles.
struct FacePlace {
  std::int32_t face;
  glm::dvec3 weights;  ///< of the face's vertices; their sum is 1
};

struct EvenTrianglesOptions {
  /// Edges aim at this part of the mean length of the given edges around.
  double spacing = 0.6;
  /// And turn by no more than this, in degrees, as far as `least_spacing` lets them.
  double turn = 10, least_spacing = 0.25;
};

/// A part of a given edge that nothing is flipped across.
struct LinePart {
  std::int32_t v0, v1;  ///< vertices
  std::int32_t edge;    ///< of the given topology
};

/// A mesh with further vertices: the given ones come first and stay where they are.
struct EvenTriangles {
  std::vector<glm::dvec3> positions;
  std::vector<std::array<std::int32_t, 3>> triangles;
  /// Of each triangle a given face that lies on its side of all lines.
  std::vector<std::int32_t> source_faces;
  std::vector<FacePlace> places;         ///< of each further vertex, on the given mesh
  std::vector<FacePlace> corner_places;  ///< of each triangle's corner, on its side of lines
  std::vector<LinePart> lines;
  std::vector<double> doubts;  ///< of the guess, 0 to 1, at each corner of the given triangles
};

/// Puts further vertices between the given ones, evenly on a smooth guess of the surface, so that
/// rings become even: edges that are long are split, edges are flipped to Delaunay's criterion, and
/// further vertices move to the middle of their rings, on the guess. The guess blends the jets of
/// each triangle's corners (see guess_surface.h); along sharp edges it is the curve through their
/// vertices. `is_line`: one per edge, those that are split but not flipped (creases, borders of
/// materials, seams); `is_sharp`: those across which normals jump: nothing is flipped across them
/// either, and they stay straight where they are no lines. Boundaries need not be named. A mesh of
/// triangles alone, each vertex of which is used.
[[nodiscard]] EvenTriangles make_even_triangles(std::span<const glm::dvec3> positions,
                                                const MeshTopology& topology,
                                                std::span<const char> is_line,
                                                std::span<const char> is_sharp,
                                                const EvenTrianglesOptions& options = {});

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
