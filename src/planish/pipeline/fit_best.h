#pragma once

#include <string>

#include "planish/pipeline/fit.h"
#include "planish/surface/surface_quality.h"

namespace planish {

/// The better of the two surfaces through a mesh's vertices, and why.
struct BestFit {
  PolygonMesh mesh;  ///< that `fit` is of: for a fair one with convex faces and cusp corners
  Fit fit;
  InterpolationMethod method = InterpolationMethod::Progressive;
  SurfaceQuality progressive, fair;  ///< at level 1, against the faces of each one's mesh
  std::string reason;                ///< in a line, for people
};

/// Fits by both methods, whatever the options' method is, and measures both at level 1: fair,
/// unless the progressive surface does not fold (less than 1e-5 of its area, where the input does
/// not itself) and its normals are off by less than 0.9 of what fair's are. That much because
/// normals are measured against the mesh's own faces, which the progressive method follows more
/// closely even where it is no nearer to the shape. Two fits at most. Throws as fit().
[[nodiscard]] BestFit fit_best(const PolygonMesh& mesh, Backend& backend,
                               const FitOptions& options = {});

}  // namespace planish
