#pragma once

#include <memory>

#include "planish/doosabin/sharp_features.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"

namespace planish {

/// The mesh, which must outlive the result, without its unused vertices. Takes what was prepared of
/// it, or of another with the same faces and tags, or else prepares it. Throws Error{UnusableMesh}.
[[nodiscard]] UsedPart usable_part(const PolygonMesh& mesh,
                                   std::shared_ptr<const PreparedMesh> prepared = nullptr);

/// A mesh with everything that its level 1 depends on besides control points; a fair net's first
/// step takes the weights of 1978.
struct SubdividedMesh {
  /// The mesh must outlive it. Makes what is not given. Throws Error{UnusableMesh}.
  SubdividedMesh(const PolygonMesh& mesh, const SharpFeatureOptions& sharp,
                 std::shared_ptr<const PreparedMesh> prepared = nullptr,
                 std::shared_ptr<const SharpFeatures> found = nullptr);
  SubdividedMesh(const SubdividedMesh&) = delete;
  SubdividedMesh& operator=(const SubdividedMesh&) = delete;

  UsedPart used;
  std::shared_ptr<const SharpFeatures> features;
  Subdivision subdivision;
};

}  // namespace planish
