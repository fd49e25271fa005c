#pragma once

#include <cstdint>

#include "planish/mesh/polygon_mesh.h"
#include "support/meshes.h"

namespace planish::test {

/// Moves every vertex by up to `amount` in each coordinate.
[[nodiscard]] PolygonMesh jittered(PolygonMesh mesh, double amount, std::uint32_t seed);

/// A jittered icosphere with randomly merged faces: 3- to 9-gons, valences from 3.
[[nodiscard]] PolygonMesh random_closed_mesh(std::uint32_t seed);

/// The dual of a random triangulation: the convex hull of `count` random points on the unit sphere,
/// a vertex at the centroid of each triangle, and one polygon of any size a point. All valences
/// are 3; surfaces that interpolate it bend tightly and fold.
[[nodiscard]] PolygonMesh random_dual(int count, std::uint32_t seed);

/// The random closed mesh with some faces taken out, still a manifold with boundary.
[[nodiscard]] PolygonMesh random_open_mesh(std::uint32_t seed);

/// Tags each edge with the given probability: darts, creases and corners arise in every mix.
[[nodiscard]] PolygonMesh with_random_creases(PolygonMesh mesh, double probability,
                                              std::uint32_t seed);

/// A random mesh with boundary, creases, darts, corners, seams, colours, groups and holes.
[[nodiscard]] PolygonMesh laden_mesh(std::uint32_t seed);

/// Vertices and faces in random order, faces started at a random corner. new_index[v] is where
/// vertex v went.
struct Relabelled {
  PolygonMesh mesh;
  std::vector<std::int32_t> new_index;
};
[[nodiscard]] Relabelled relabelled(const PolygonMesh& mesh, std::uint32_t seed);

/// The convex hull of `count` uniformly random points of the unit sphere, which is their Delaunay
/// triangulation: rings as uneven as random sampling makes them. count >= 4.
[[nodiscard]] PolygonMesh delaunay_sphere(int count, std::uint32_t seed);

}  // namespace planish::test
