#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "quality/cases.h"

namespace planish::quality {

struct IrregularOptions {
  std::filesystem::path manifold;  ///< see smoothed_by_manifold(); empty: no peer
  int more_levels = 0;             ///< finer than what is written by default
};

/// Facets of meshes of uneven triangles against the shapes that these were taken from: the flat
/// triangles, what planish writes by default, and manifold-3d's at about as many facets. Returns
/// what falls short of truth; the peer has no say in that.
[[nodiscard]] std::vector<std::string> print_irregular_table(const std::vector<NamedCase>& cases,
                                                             const IrregularOptions& options);

}  // namespace planish::quality
