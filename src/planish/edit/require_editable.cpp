#include "planish/edit/require_editable.h"

#include <string>

#include "planish/core/error.h"
#include "planish/surface/evaluate.h"

namespace planish {

void require_editable(const PolygonMesh& mesh, const Fit& fit, const EditorOptions& options) {
  require_level(options.level);
  if (fit.within && fit.within->bound(options.fit.tolerance) > 0) {
    throw Error(ErrorCode::InvalidArgument,
                "the fit leaves the vertices within a bound, so that moving one has no place to "
                "go to; edit a fit with within = 0");
  }
  if (!fit.interpolation.converged) {
    throw Error(ErrorCode::InvalidArgument,
                "the fit has not reached its tolerance (" +
                    std::string(name_of(fit.interpolation.stop_reason)) +
                    "); edit one that has, or take fair interpolation");
  }
  if (fit.prepared == nullptr || fit.prepared->given_vertex_count != mesh.vertex_count()) {
    throw Error(ErrorCode::InvalidArgument,
                "the fit is of " +
                    std::to_string(fit.prepared ? fit.prepared->given_vertex_count : 0) +
                    " vertices, the mesh has " + std::to_string(mesh.vertex_count()));
  }
  if (options.fit.scheme != Scheme::DooSabin) {
    throw Error(ErrorCode::InvalidArgument,
                "fits of another scheme than Doo-Sabin cannot be edited; fit again with scheme "
                "doo-sabin");
  }
}

}  // namespace planish
