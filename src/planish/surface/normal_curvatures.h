#pragma once

#include <vector>

#include "planish/surface/surface_mesh.h"

namespace planish {

/// Curvatures of a surface at each vertex of a tessellation, in one over the model's unit and its
/// square. Mean curvature is positive where the surface bends away from its normal: 1/R on a sphere
/// of radius R with outward normals.
struct Curvatures {
  std::vector<float> mean, gaussian;
};

/// The curvatures that the exact normals show across the tessellation's edges and diagonals: the
/// shape operator that fits their differences best in the least squares. Second order in the size
/// of the faces where they lie evenly. 0 where the faces around a vertex leave it open.
[[nodiscard]] Curvatures curvatures_of_normals(const SurfaceMesh& surface);

}  // namespace planish
