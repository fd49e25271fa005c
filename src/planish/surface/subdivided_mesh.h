#pragma once

#include <memory>

#include "planish/doosabin/sharp_features.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"
#include "planish/stencil/quad_split.h"
#include "planish/surface/evaluate.h"

namespace planish {

/// The mesh, which must outlive the result, without its unused vertices. Takes what was prepared of
/// it, or of another with the same faces and tags, or else prepares it. Throws Error{UnusableMesh}.
[[nodiscard]] UsedPart usable_part(const PolygonMesh& mesh,
                                   std::shared_ptr<const PreparedMesh> prepared = nullptr);

/// Evaluates the mesh itself, with these sharp features.
[[nodiscard]] EvaluateOptions first_level(const SharpFeatureOptions& sharp);

/// A mesh with everything that Doo-Sabin's tables depend on besides control points, down to a
/// level.
struct SubdividedMesh {
  /// The mesh must outlive it. Takes what was prepared, the level, the weights, what is sharp and
  /// the rest pose of the options. Throws Error{UnusableMesh}, and Error{OutOfMemory} for what
  /// evaluating that level needs.
  SubdividedMesh(const PolygonMesh& mesh, const EvaluateOptions& options);
  SubdividedMesh(const SubdividedMesh&) = delete;
  SubdividedMesh& operator=(const SubdividedMesh&) = delete;

  UsedPart used;
  QuadSplit split;
  SharpFeatures features;
  Subdivision subdivision;
};

}  // namespace planish
