#pragma once

#include <functional>
#include <string>
#include <vector>

#include "planish/mesh/triangles.h"
#include "quality/figures.h"

namespace planish::quality {

/// Makes its case when it is wanted.
struct NamedCase {
  std::string name;
  std::function<Case()> make;
};

/// Small shapes of known form.
[[nodiscard]] std::vector<NamedCase> analytic_cases();

/// Further such shapes, of which none was looked at before the method was finished.
[[nodiscard]] std::vector<NamedCase> second_held_out_cases();

/// Spheres, tori and ellipsoids in quads, triangles and polygons, each at several densities.
[[nodiscard]] std::vector<NamedCase> dense_cases();

/// Arm, bust and goblet in few triangles, at several tolerances.
[[nodiscard]] std::vector<NamedCase> decimated_cases();

/// The scenes' rocker arm and others, sampled and meshed by `mesher`, and creased parts.
[[nodiscard]] std::vector<NamedCase> scanned_cases(const Mesher& mesher);

/// The files rocker-arm.obj, spot.obj and suzanne.obj in the folder that PLANISH_TEST_DATA names;
/// none where it is not set.
[[nodiscard]] std::vector<NamedCase> file_cases();

}  // namespace planish::quality
