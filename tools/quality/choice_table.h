#pragma once

#include "quality/cases.h"

namespace planish::quality {

/// Prints which surface fit_mesh() takes of each case whose shape is known, and by how much the
/// other one is nearer to that shape, by the normals' rms deviation. Returns a line for each case
/// where the one that is taken is farther off, by more than a tenth and 0.1 degrees.
[[nodiscard]] std::vector<std::string> print_choice_table(const std::vector<NamedCase>& cases);

}  // namespace planish::quality
