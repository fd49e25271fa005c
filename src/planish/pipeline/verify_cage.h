#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_net.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/primal/scheme.h"
#include "planish/quads/pair_triangles.h"
#include "planish/refine/refine_mesh.h"
#include "planish/solve/backend.h"

namespace planish {

struct VerifyOptions {
  InterpolationMethod method = InterpolationMethod::Progressive;
  Scheme scheme = Scheme::DooSabin;
  Weights weights = Weights::DooSabin;  ///< of Doo-Sabin
  SharpFeatureOptions sharp;
  bool repairs = true;                   ///< of the given mesh, as when it was fitted
  bool finds_features = false;           ///< the same
  std::optional<double> crease_degrees;  ///< the same
  std::optional<double> weld;            ///< the same
  /// FittedMesh::found, in place of a search by the two.
  const FoundCreases* found = nullptr;
  /// Of the given mesh, as when it was fitted; auto: joined where the cage is of no other faces.
  QuadChoice quads = QuadChoice::Auto;
  /// The same, of the fair method; auto: added where the cage is of no other faces.
  RefineChoice refine = RefineChoice::Auto;
  double tolerance = 1e-6;
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
