#pragma once

#include <string>
#include <vector>

#include "quality/cases.h"

namespace planish::quality {

/// What comes out without a flag, beside the best of all combinations of flags, of meshes and of
/// noisy clouds of known shape. Returns what is more than a tenth farther off the shape's normals.
std::vector<std::string> print_default_table(const std::vector<NamedCase>& meshes,
                                             const Mesher* mesher);

}  // namespace planish::quality
