#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/primal/scheme.h"

namespace planish::test {

/// A mesh in the course of explicit Catmull-Clark or Loop subdivision, by the rules as published
/// (DeRose, Kass & Truong 1998 for creases, averaged where several decay at once). Slow and literal
/// on purpose: it knows no masks and no OpenSubdiv.
struct ExplicitPrimal {
  using Edge = std::array<std::int32_t, 2>;  ///< ascending

  std::vector<glm::dvec3> points;
  std::vector<std::vector<std::int32_t>> faces;
  std::map<Edge, double> edge_sharpness;  ///< of tagged edges; boundaries are sharp anyway
  std::map<std::int32_t, double> vertex_sharpness;  ///< of tagged vertices
};

[[nodiscard]] ExplicitPrimal explicit_primal(const PolygonMesh& mesh);

/// Vertices: those of the mesh in their places, then one per face (Catmull-Clark), then the edges'.
/// Faces: one per corner of each face in order, then (Loop) the middle triangle.
[[nodiscard]] ExplicitPrimal explicit_step(const ExplicitPrimal& mesh, PrimalScheme scheme);
[[nodiscard]] ExplicitPrimal explicit_levels(const PolygonMesh& mesh, PrimalScheme scheme,
                                             int levels);

/// Where one vertex goes, by subdividing the faces around it alone 60 times, magnified and centred
/// anew after each step: no other faces matter once all are quads (triangles).
struct ExplicitLimit {
  glm::dvec3 point;
  /// By face of `mesh` around the vertex: the unit normal of a late descendant at the vertex.
  std::map<std::int32_t, glm::dvec3> normals;
};
/// `mesh` has one step behind it at least.
[[nodiscard]] ExplicitLimit explicit_limit(const ExplicitPrimal& mesh, PrimalScheme scheme,
                                           std::int32_t vertex);

}  // namespace planish::test
