#pragma once

#include "planish/limit/adaptive_tessellation.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish {

/// Triangles of a fit's Doo-Sabin surface as fine as it is curved, in one call: tessellate() of
/// fitted_surface(). Of the options `diagonal` is not looked at: errors are parts of the fit's.
/// Throws as both.
[[nodiscard]] SurfaceMesh tessellate(const PolygonMesh& mesh, const Fit& fit,
                                     AdaptiveOptions options, const EvaluateOptions& evaluate = {});

/// The same of a mesh that fit_mesh() fitted. Throws Error{InvalidArgument} for another scheme than
/// Doo-Sabin, too.
[[nodiscard]] SurfaceMesh tessellate(const FittedMesh& fitted, const AdaptiveOptions& options);

}  // namespace planish
