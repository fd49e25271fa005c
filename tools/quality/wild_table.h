#pragma once

#include <string>
#include <vector>

#include "quality/cases.h"

namespace planish::quality {

/// Fits each case by the progressive method with Doo and Sabin's weights, the fair one, and the
/// fair one with found creases, and prints a row: folds that the input is not to blame for, the
/// worst of levels 1 to 3, and normals' rms deviation from the input's faces at level 2.
/// Returns the cases on which a fair surface folds, a line each.
[[nodiscard]] std::vector<std::string> print_wild_table(const std::vector<NamedCase>& cases);

}  // namespace planish::quality
