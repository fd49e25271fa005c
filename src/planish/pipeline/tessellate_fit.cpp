#include "planish/pipeline/tessellate_fit.h"

#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/limit/limit_surface.h"

namespace planish {

SurfaceMesh tessellate(const PolygonMesh& mesh, const Fit& fit, AdaptiveOptions options,
                       const EvaluateOptions& evaluate) {
  const HostScope host(options.callbacks);
  const LimitSurface limit(fitted_surface(mesh, fit, evaluate));
  options.diagonal = fit.placement.diagonal;
  return tessellate(limit, options).mesh;
}

SurfaceMesh tessellate(const FittedMesh& fitted, const AdaptiveOptions& options) {
  if (fitted.options.scheme != Scheme::DooSabin) {
    throw Error(ErrorCode::InvalidArgument,
                "tessellate: only Doo-Sabin surfaces are tessellated by error and angle; fit with "
                "that scheme, or evaluate a level");
  }
  return tessellate(fitted.mesh, fitted.fit, options, fitted.evaluate_options());
}

}  // namespace planish
