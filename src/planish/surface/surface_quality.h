#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>

#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

/// How well the normals of a surface follow a reference. Angles in degrees, weighted by area, each
/// face's area shared among its corners.
struct SurfaceQuality {
  double folded_area = 0;  ///< share of the area turned by more than 90 degrees from the reference
  double rms_normal_deviation = 0;
  double max_normal_deviation = 0;
  /// The integral of |dn|^2, the sum of both squared principal curvatures, whatever the size: 8 pi
  /// for a sphere. One tight fold dominates it.
  double bending = 0;
};

/// The normal that the surface should have at a corner of one of its faces; any length, zero where
/// there is none.
using ReferenceNormal = std::function<glm::dvec3(std::int64_t face, std::int32_t corner)>;

/// Called from one thread, face by face in order.
[[nodiscard]] SurfaceQuality surface_quality(const SurfaceMesh& surface,
                                             const ReferenceNormal& reference);

/// Against the faces of the mesh that was fitted, each for its own descendants; any level.
[[nodiscard]] SurfaceQuality surface_quality(const SurfaceMesh& surface, const PolygonMesh& input);

}  // namespace planish
