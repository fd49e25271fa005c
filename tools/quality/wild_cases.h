#pragma once

#include <vector>

#include "quality/cases.h"

namespace planish::quality {

/// Meshes as other people's files hold them (wild_shapes.h, part_shapes.h), every kind twice: once
/// to choose constants by, once held out until they were fixed.
[[nodiscard]] std::vector<NamedCase> wild_cases();

}  // namespace planish::quality
