#pragma once

#include <string>
#include <vector>

#include "planish/refine/refine_mesh.h"
#include "quality/cases.h"

namespace planish::quality {

/// What comes out without a flag, beside the best of all combinations of flags, of meshes and of
/// noisy clouds of known shape. Returns what is more than a tenth farther off the shape's normals.
/// `refine`: whether vertices are added to the meshes.
std::vector<std::string> print_default_table(const std::vector<NamedCase>& meshes,
                                             const Mesher* mesher, RefineChoice refine);

}  // namespace planish::quality
