#pragma once

#include <cstdint>

#include "planish/mesh/mesh_topology.h"

namespace planish {

/// A place on the surface of a mesh's face, as OpenSubdiv's Bfr::Parameterization has it. On a face
/// of four, (u, v) in [0, 1]^2 with corner i at (0, 0), (1, 0), (1, 1), (0, 1). On others (u, v)
/// lies in one of m tiles of half a unit, one a corner, at (i % d, i / d): its origin is at the
/// corner, u runs along the face's edge to the next one, and (1/2, 1/2) is the face's centre; d = 2
/// up to four faces, 3 up to nine, then 1 + floor(sqrt(m - 1)).
struct SurfaceParameter {
  std::int32_t face = 0;
  double u = 0, v = 0;
};

/// The same seen from the corner that it belongs to: u runs from the corner's vertex to the
/// midpoint of its leading edge, v to that of its trailing edge, both from 0 to 1; (1, 1) is the
/// face's centre.
struct CornerParameter {
  std::int32_t corner = 0;
  double u = 0, v = 0;
  /// How derivatives by (u, v) become those by a SurfaceParameter's, see PatchPoint::turned() with
  /// factor 2.
  int turn_c = 1, turn_s = 0;
};

/// Throws Error{InvalidArgument} for a face that is none, and for places further than 1e-9 outside
/// it; nearer ones are taken to the border.
[[nodiscard]] CornerParameter corner_parameter(const MeshTopology& topology,
                                               const SurfaceParameter& at);

/// The inverse. (u, v) must be in [0, 1]^2.
[[nodiscard]] SurfaceParameter surface_parameter(const MeshTopology& topology, std::int32_t corner,
                                                 double u, double v);

}  // namespace planish
