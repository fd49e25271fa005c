#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "planish/backend/backend.h"
#include "planish/core/callbacks.h"
#include "planish/doosabin/face_rule.h"
#include "planish/doosabin/sharp_features.h"
#include "planish/interpolate/progressive.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

struct FitOptions {
  Weights weights = Weights::DooSabin;
  Solver solver = Solver::Chebyshev;
  double tolerance = 1e-6;         ///< of the maximum error, relative to the bounding-box diagonal
  std::int32_t max_iterations = 200;
  BoundaryRule boundary = BoundaryRule::Edge;
  bool use_creases = true;         ///< false: ignore the mesh's crease and corner tags
  Callbacks callbacks;
};

/// Wall-clock milliseconds of the parts of fit().
struct FitTiming {
  double check = 0, stencils = 0, upload = 0, solve = 0;
};

/// A control cage whose limit surface passes through the given vertices.
struct Fit {
  PolygonMesh cage;                ///< the input with its positions replaced by control points
  Interpolation interpolation;
  Placement placement;             ///< of the input
  double spectral_bound = 0;
  std::int64_t stencil_entries = 0;
  std::int32_t sharp_edge_count = 0, corner_count = 0;  ///< boundary edges are sharp
  FitTiming timing;
};

/// Finds the control cage: check, limit stencils, progressive interpolation.
/// Throws Error{UnusableMesh}, Error{InvalidArgument} (conjugate gradients on a mesh that is not
/// closed and smooth), Error{OutOfMemory}, Error{Cancelled}. Not converging is a result.
[[nodiscard]] Fit fit(const PolygonMesh& mesh, Backend& backend, const FitOptions& options = {});

struct EvaluateOptions {
  int level = 2;                   ///< 0 to kMaxLevel quad splits
  Weights weights = Weights::DooSabin;
  BoundaryRule boundary = BoundaryRule::Edge;
  bool use_creases = true;
  /// Where given, sector angles at corners are measured on these positions (the rest pose: the
  /// input's vertices), not on the cage's.
  std::span<const glm::dvec3> rest_positions;
  std::uint64_t memory_limit_bytes = 0;  ///< 0: what the machine has free
  Callbacks callbacks;
};
inline constexpr int kMaxLevel = 6;

/// The tessellated limit surface of a control cage.
/// Throws Error{UnusableMesh}, Error{OutOfMemory} before memory is taken, Error{Cancelled}.
[[nodiscard]] SurfaceMesh evaluate(const PolygonMesh& cage, Backend& backend,
                                   const EvaluateOptions& options = {});

/// Limit positions of the cage's vertices in double on the CPU, independent of any backend's
/// precision: what `planish verify` measures. Unused vertices stay where they are.
[[nodiscard]] std::vector<glm::dvec3> limit_positions(const PolygonMesh& cage, Weights weights,
                                                      BoundaryRule boundary, bool use_creases);

/// Area of `surface` whose limit normal is turned by more than 90 degrees from the normal of the
/// input face it came from, as a fraction of the whole area. Level >= 1.
[[nodiscard]] double folded_area(const SurfaceMesh& surface, const PolygonMesh& input);

}  // namespace planish
