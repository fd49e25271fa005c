#pragma once

#include <string>
#include <vector>

#include "quality/cases.h"

namespace planish::quality {

/// Props, parts and vehicles as technical artists have them, a true shape for each; half of them
/// held out, by lot.
[[nodiscard]] std::vector<NamedCase> prop_cases();

/// What comes out of them without a flag, beside the best of all combinations of flags. Returns
/// what is more than a tenth farther off the shape's normals.
std::vector<std::string> print_prop_table(const std::vector<NamedCase>& cases);

}  // namespace planish::quality
