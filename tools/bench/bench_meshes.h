#pragma once

#include <cstdint>
#include <string>

#include "planish/mesh/polygon_mesh.h"

namespace planish::bench {

/// Torus R = 1, r = 0.4 of about `quad_count` quads, as many around as along.
[[nodiscard]] PolygonMesh torus_grid(std::int32_t quad_count);

/// Torus R = 1, r = 0.4 of about `quad_count` quads whose vertices are moved by up to a fifth of an
/// edge, each cut along either diagonal by lot. The same bits on every call.
[[nodiscard]] PolygonMesh irregular_triangles(std::int32_t quad_count);

/// Icosahedron split `level` times, every vertex moved along its radius by up to 1 %: the initial
/// error of scanned models on an irregular mesh of triangles. The same bits on every call.
[[nodiscard]] PolygonMesh rough_icosphere(int level);

/// Two vertices of `valence` triangles each, off the middle of a rim as uneven as a star's.
[[nodiscard]] PolygonMesh uneven_bipyramid(std::int32_t valence);

/// The mesh as Wavefront OBJ text.
[[nodiscard]] std::string obj_text(const PolygonMesh& mesh);

}  // namespace planish::bench
