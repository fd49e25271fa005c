#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// A closed polygon mesh in the course of explicit Doo-Sabin subdivision: every step makes a new
/// mesh of face polygons, edge quads and vertex polygons. Slow and literal on purpose: it is what
/// the library's dual formulation is held against.
struct ExplicitMesh {
  /// A face's corner, and the half-edge that leaves it.
  struct Corner {
    std::int32_t face, corner;
  };

  std::vector<glm::dvec3> points;
  std::vector<std::vector<std::int32_t>> faces;  ///< counter-clockwise
  /// twins[f][i] is the face and corner where the other half of the edge from corner i of face f
  /// begins. Kept explicitly: around a vertex of valence 2 two points are joined by two edges.
  std::vector<std::vector<Corner>> twins;
  std::vector<Corner>
      origins;  ///< the corner of the previous mesh that each point was made for; empty at level 0
  /// The polygon that has shrunk towards each base vertex's limit point; empty at level 0.
  std::vector<std::int32_t> polygon_of_base_vertex;
};

/// New corner points of one polygon. `Averaged` literally averages the vertex, the centroid and
/// the two edge midpoints; `DooSabin` uses the weights of Doo & Sabin 1978.
[[nodiscard]] std::vector<glm::dvec3> shrunk_polygon(Weights weights,
                                                     const std::vector<glm::dvec3>& polygon);

[[nodiscard]] ExplicitMesh explicit_mesh(const PolygonMesh& mesh);
[[nodiscard]] ExplicitMesh explicit_step(const ExplicitMesh& mesh, Weights weights);
[[nodiscard]] ExplicitMesh explicit_levels(const PolygonMesh& mesh, Weights weights, int levels);

[[nodiscard]] glm::dvec3 face_centroid(const ExplicitMesh& mesh, std::int32_t face);

/// Limit points of the base vertices: the centroids of their polygons, which no step moves.
[[nodiscard]] std::vector<glm::dvec3> explicit_limit_points(const ExplicitMesh& mesh);

}  // namespace planish::test
