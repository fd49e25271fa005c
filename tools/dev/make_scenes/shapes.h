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

/// Every function here returns a mesh that passes check(), counter-clockwise seen from outside,
/// and the same one on every run. Throws std::invalid_argument for counts it cannot serve.

/// Axis-aligned cube from -1 to 1, each side `cells` x `cells` quads (cells >= 1).
[[nodiscard]] PolygonMesh cube(std::int32_t cells = 1);

/// Cube from -1 to 1 of `cells` cells an edge, with a square tunnel `hole_cells` wide drilled
/// through along each axis: quads only, genus 5. cells - hole_cells must be even and positive.
[[nodiscard]] PolygonMesh cube_with_tunnels(std::int32_t cells, std::int32_t hole_cells);

struct TorusOptions {
  std::int32_t ring_count = 64;  ///< quads the long way round, >= 3
  std::int32_t tube_count = 32;  ///< quads around the tube, >= 3
  double radius = 1.0;           ///< axis to the middle of the tube
  double tube_radius = 0.4;
};
/// Torus around the z axis, ring_count * tube_count quads and as many vertices.
[[nodiscard]] PolygonMesh torus(const TorusOptions& options = {});

/// Unit sphere of 20 * 4^level triangles; 10 * 4^level + 2 vertices.
[[nodiscard]] PolygonMesh icosphere(std::int32_t level);

/// Unit sphere in `ring_count` rings of `segment_count` quads; the north pole is a vertex of
/// valence segment_count, the south pole one polygon of segment_count corners.
[[nodiscard]] PolygonMesh pole_sphere(std::int32_t segment_count, std::int32_t ring_count);

/// Open planar grid over [0, 1] x [0, rows / columns] at z = 0.
[[nodiscard]] PolygonMesh open_grid(std::int32_t columns, std::int32_t rows);

/// open_grid bent to z = 0.1 sin(2 pi x) cos(2 pi y).
[[nodiscard]] PolygonMesh wavy_patch(std::int32_t columns, std::int32_t rows);

/// Planar open plate of 3 x 2 square tiles at z = 0, four of them with a round hole: genus 0,
/// five boundary loops.
[[nodiscard]] PolygonMesh plate_with_holes();

/// An L of two plates: 12 vertices, two concave 6-gons and six quads.
[[nodiscard]] PolygonMesh l_bracket();

/// cube(cells) with a chart of texture coordinates for each side, in 3 x 2 cells of the unit
/// square, its vertices coloured by position, the z sides a group of their own.
[[nodiscard]] PolygonMesh mapped_cube(std::int32_t cells);

/// cube(3) whose middle quads are holes.
[[nodiscard]] PolygonMesh cube_with_windows();

/// Square base plate with a round boss and a bore through both; genus 1. Edges whose faces
/// meet at more than 30 degrees are tagged as creases, the four upright corners semi-sharp.
[[nodiscard]] PolygonMesh bearing_block();

/// The faces around each vertex become one polygon, at the face centroids. The mesh must be closed.
[[nodiscard]] PolygonMesh dual(const PolygonMesh& mesh);

struct RandomMeshOptions {
  std::uint32_t seed = 1;
  std::int32_t level = 3;         ///< of the icosphere it starts from
  double merged_share = 0.4;      ///< share of the edges that are tried for merging two faces
  std::int32_t largest_face = 8;  ///< corners
  double jitter = 0.1;            ///< displacement of a vertex in edge lengths
};

/// Closed bumpy ball of 3..largest_face-gons, genus 0: an icosphere whose edges were dropped at
/// random. The same options give the same mesh on every machine. Always passes check().
[[nodiscard]] PolygonMesh random_polygon_mesh(const RandomMeshOptions& options = {});

/// Closed ellipsoid of 3- to 12-gons, three at every vertex: the dual of an icosphere whose edges
/// were flipped at random. The same seed gives the same mesh on every machine.
[[nodiscard]] PolygonMesh mixed_polygons(std::uint32_t seed = 1);

}  // namespace planish::shapes
