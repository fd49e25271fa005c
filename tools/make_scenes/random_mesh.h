#pragma once

#include <cstdint>

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

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
