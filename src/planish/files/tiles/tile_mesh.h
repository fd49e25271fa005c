#pragma once

#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/files/tiles/tile_grid.h"
#include "planish/files/tiles/tile_plan.h"
#include "planish/surface/doo_sabin_blocks.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

/// Smallest and largest coordinates.
struct TileBox {
  glm::dvec3 lower{0.0}, upper{0.0};

  void add(const TileBox& other) {
    lower = glm::min(lower, other.lower);
    upper = glm::max(upper, other.upper);
  }
  void add(const glm::dvec3& point) { add({point, point}); }
  [[nodiscard]] glm::dvec3 centre() const { return 0.5 * (lower + upper); }
  [[nodiscard]] glm::dvec3 half() const { return 0.5 * (upper - lower); }
};

/// What all tiles of a level are made of.
struct TileSource {
  const DooSabinBlocks& blocks;
  const MeshTopology& topology;
  const TilePlan& plan;
  const TileGrid& grid;
};

/// A tile as it is written.
struct TileMesh {
  SurfaceMesh mesh;              ///< about the tile's origin, on the grid
  RawVector<std::int32_t> rows;  ///< the surface's row of each vertex, ascending
  DegenerateRows degenerate;
};

/// The descendants of a tile's faces, ascending.
[[nodiscard]] std::vector<RowRange> faces_of_tile(const TileSource& source,
                                                  const PlannedTile& tile);

/// The faces of a tile with their rows in the surface's order and all attributes. The same bits as
/// the surface in one piece, but for the grid.
[[nodiscard]] TileMesh make_tile(const TileSource& source, const PlannedTile& tile,
                                 const glm::dvec3& origin);

[[nodiscard]] TileBox box_of(const SurfaceMesh& mesh);

/// Of the vertices of some faces, one at least; `point(vertex)` says where they are.
template <class Point>
[[nodiscard]] TileBox box_of_faces(const MeshTopology& topology,
                                   std::span<const std::int32_t> faces, const Point& point) {
  const glm::dvec3& first = point(topology.face(faces.front()).front());
  TileBox box{first, first};
  for (const std::int32_t face : faces)
    for (const std::int32_t vertex : topology.face(face)) box.add(point(vertex));
  return box;
}

/// How far the quads of level l - 1 are from those of a mesh of level l >= 2, which come four by
/// four in its place: the largest distance of a middle or a centre from its place on the bilinear
/// quad, and a quarter of the quad's twist. An estimate of their distance from the limit surface.
[[nodiscard]] double coarser_error(const SurfaceMesh& mesh);

/// Adds strips of that length along the tile's edges to others, against the normals: what shows
/// through a gap between tiles of different levels is the surface. Not along the surface's own
/// boundary.
void add_skirts(const TileSource& source, const PlannedTile& tile, double length, TileMesh& made);

}  // namespace planish
