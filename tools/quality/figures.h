#pragma once

#include <string>
#include <vector>

#include "planish/pipeline/fit_mesh.h"
#include "quality/truth.h"

namespace planish::quality {

/// A mesh with what its surface should be.
struct Case {
  std::string name;
  PolygonMesh mesh;
  /// Empty: normals are compared with those of the mesh's own faces (facets have no smooth truth,
  /// and the nearest face beside a crease may be the one behind it), distances with `source`.
  Truth truth;
  PolygonMesh source;              ///< without faces: the mesh itself
  bool has_smooth_source = false;  ///< fine enough for normals as well
  bool is_scan = false;
  bool is_held_out = false;  ///< of no part in choosing the method's constants
};

/// A way to a surface.
struct Method {
  std::string name;
  bool interpolates;
  FitOptions options;
};
/// None, progressive with either weights, fair without and with polish; in this order.
[[nodiscard]] const std::vector<Method>& methods();

/// Of one surface. Lengths are fractions of the mesh's diagonal, angles in degrees.
struct Figures {
  double folded_area = 0;  ///< a fraction
  double rms_normal = 0, max_normal = 0;
  double bending = 0;  ///< over the truth's; without a smooth truth over a sphere's, 8 pi
  double max_distance = 0, rms_distance = 0;
  double interpolation_error = 0;
};

/// Fits and measures at the limit points of a fine tessellation: level 3, or 2 for large meshes.
[[nodiscard]] Figures measure(const Case& what, const Method& method);
/// The same of a finished fit, at level 2; each face against the piece of the source between sharp
/// edges that it was taken from.
[[nodiscard]] Figures measure(const Case& what, const FittedMesh& fitted, Backend& backend);

}  // namespace planish::quality
