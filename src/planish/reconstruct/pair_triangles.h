#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/mesh/polygon_mesh.h"
#include "planish/reconstruct/triangles.h"

namespace planish {

struct PairOptions {
  double largest_turn = 30;    ///< degrees between the two triangles' normals
  double largest_angle = 150;  ///< degrees at a corner of a quad; below 180, so quads are convex
};

/// Joins neighbouring triangles to quads: greedily by how near the quad's corners come to right
/// angles, then pairs are exchanged where that leaves two triangles fewer alone. Triangles without
/// a partner stay. Each quad begins at an end of the edge that it lost:
/// cut into a fan it is the two triangles again. Positions are copied, unused ones too; the
/// triangles must be an oriented manifold.
[[nodiscard]] PolygonMesh pair_triangles(std::span<const glm::dvec3> positions,
                                         std::span<const Triangle> triangles,
                                         const PairOptions& options = {});

}  // namespace planish
