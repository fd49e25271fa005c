#pragma once

#include "planish/doosabin/sharp_features.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/used_vertices.h"
#include "planish/stencil/quad_split.h"
#include "planish/surface/evaluate.h"

namespace planish {

/// The mesh without its unused vertices. Throws Error{UnusableMesh}.
[[nodiscard]] UsedMesh usable_part(const PolygonMesh& mesh);

/// A mesh with everything that Doo-Sabin's tables depend on besides control points, down to a
/// level.
struct SubdividedMesh {
  /// Takes the level, the weights, what is sharp and the rest pose of the options. Throws
  /// Error{UnusableMesh}, and Error{OutOfMemory} for what evaluating that level needs.
  SubdividedMesh(const PolygonMesh& mesh, const EvaluateOptions& options);
  SubdividedMesh(const SubdividedMesh&) = delete;
  SubdividedMesh& operator=(const SubdividedMesh&) = delete;

  UsedMesh used;
  QuadSplit split;
  SharpFeatures features;
  Subdivision subdivision;
};

}  // namespace planish
