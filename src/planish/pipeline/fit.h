#pragma once

#include <cstdint>

#include "planish/backend/backend.h"
#include "planish/core/callbacks.h"
#include "planish/doosabin/face_rule.h"
#include "planish/doosabin/sharp_features.h"
#include "planish/interpolate/progressive.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

struct FitOptions {
  Weights weights = Weights::DooSabin;
  Solver solver = Solver::Chebyshev;
  double tolerance = 1e-6;  ///< of the maximum error, relative to the bounding-box diagonal
  std::int32_t max_iterations = 200;
  SharpFeatureOptions sharp;
  Callbacks callbacks;
};

/// Wall-clock milliseconds of the parts of fit(): tests of the mesh, the topology refiner, limit
/// stencils, their way to the device, and the solve.
struct FitTiming {
  double check = 0, topology = 0, stencils = 0, upload = 0, solve = 0;
};

/// A control cage whose limit surface passes through the given vertices.
struct Fit {
  PolygonMesh cage;  ///< the input with its positions replaced by control points
  Interpolation interpolation;
  Placement placement;  ///< of the input
  double spectral_bound = 0;
  std::int64_t stencil_entries = 0;
  std::int32_t sharp_edge_count = 0;  ///< boundary edges included
  std::int32_t boundary_edge_count = 0;
  std::int32_t corner_count = 0;
  FitTiming timing;
};

/// Finds the control cage: check, limit stencils, progressive interpolation.
/// Throws Error{UnusableMesh}, Error{InvalidArgument} (conjugate gradients on a mesh that is not
/// closed and smooth), Error{OutOfMemory}, Error{Cancelled}. Not converging is a result.
[[nodiscard]] Fit fit(const PolygonMesh& mesh, Backend& backend, const FitOptions& options = {});

}  // namespace planish
