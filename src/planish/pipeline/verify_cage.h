#pragma once

#include <cstdint>
#include <string>

#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"

namespace planish {

struct VerifyOptions {
  /// What the given mesh was fitted with. An empty method is the progressive one; quads and added
  /// vertices that are left open: where the cage is of no other faces. Callbacks, and how it was
  /// solved, are not looked at.
  MeshFitOptions fit;
  /// FittedMesh::found, in place of a search.
  const FoundCreases* found = nullptr;
  double tolerance = 1e-6;                              ///< of the diagonal
  bool cage_has_tags = true;                            ///< false: it takes the given mesh's
  std::string cage_name = "cage", given_name = "mesh";  ///< in messages
};

/// How far the given vertices are from the cage's limit surface, as fractions of the given mesh's
/// bounding-box diagonal.
struct Verification {
  ErrorNorms error;
  std::int64_t worst_vertex = -1;
  std::int64_t vertex_count = 0;
  bool confirmed = false;  ///< error.max is at most the tolerance
};

/// Evaluates the cage's limit points in double on the CPU and compares them with the given
/// vertices. Progressive: these are the cage's first ones. Fair: the cage is the mesh of level 1,
/// see level_one_mesh(). Throws Error{UnusableMesh} for a cage that is no cage of the given mesh:
/// other numbers of vertices, or other faces.
[[nodiscard]] Verification verify_cage(const PolygonMesh& cage, const PolygonMesh& given,
                                       const VerifyOptions& options = {});

}  // namespace planish
