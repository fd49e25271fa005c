#pragma once

#include <cstdint>
#include <span>

#include "planish/brep/brep.h"
#include "planish/brep/spline_surface.h"
#include "planish/core/callbacks.h"
#include "planish/limit/limit_surface.h"

namespace planish {

constexpr double kMostBrepAngle = 90;
constexpr std::int32_t kMostFaceSize = 4096;

struct BrepOptions {
  double angle = 0.25;          ///< degrees that normals may jump by at edges
  double deviation = 1e-6;      ///< from the surface along its normals, of the diagonal
  std::int32_t face_size = 16;  ///< quads of Q_1 on a face's side, of which a mesh's quad has two
};

/// The surface as B-spline faces without holes between them: exact but in squares of 2^-m of a quad
/// at extraordinary points, or of twice that where points beside are moved towards the tangent
/// plane. These are halved until the options' limits are kept (m at most 12: see Brep::max_angle).
/// Borders of neighbours are equal. Hidden faces are left out. The same bits for every number of
/// threads. `groups`: one for each face of the mesh, that Brep::Face::group has and at whose
/// borders faces end; empty: all have 0. Reports step "faces". Throws Error{InvalidArgument} for
/// options out of range, Error{OutOfMemory} before memory is taken, Error{Cancelled}.
[[nodiscard]] Brep make_brep(const SplineSurface& surface, const BrepOptions& options = {},
                             const Callbacks& callbacks = {},
                             std::span<const std::int32_t> groups = {});
/// The same of a Doo-Sabin surface.
[[nodiscard]] Brep make_brep(const LimitSurface& surface, const BrepOptions& options = {},
                             const Callbacks& callbacks = {},
                             std::span<const std::int32_t> groups = {});

}  // namespace planish
