#pragma once

#include <string>
#include <vector>

#include "quality/figures.h"

namespace planish::quality {

/// A line of that.
[[nodiscard]] std::string shortfall(const Case& what, const char* figure, double value,
                                    double limit);

/// Where the polished fair surface falls short of what it is meant to reach, one line each: on
/// closed meshes at most 0.001 % folded; on any mesh normals no worse than those of the progressive
/// method with Doo and Sabin's weights, on simplified scans at most half as far off; interpolation
/// within 1e-6 of the diagonal. `figures` are those of methods().
[[nodiscard]] std::vector<std::string> shortfalls(const Case& what,
                                                  const std::vector<Figures>& figures);

}  // namespace planish::quality
