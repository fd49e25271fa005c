#pragma once

#include <string>
#include <string_view>

#include "planish/pipeline/settings.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish::command {

/// Everything that can be set for one job, by flags of `fit` or keys of a scene file: the rows of
/// option_table() and point_option_table().
struct Settings : FitSettings {
  ReconstructOptions points;  ///< how a point cloud becomes a mesh
};

// Stable names, as given in flags and written in reports.
[[nodiscard]] std::string_view name_of(Scheme scheme);
[[nodiscard]] std::string_view name_of(Weights weights);
[[nodiscard]] std::string_view name_of(InterpolationMethod method);
[[nodiscard]] std::string_view name_of(Solver solver);
[[nodiscard]] std::string_view name_of(BoundaryRule boundary);

/// The subdivision for people: "doo-sabin weights", "averaged weights", "catmull-clark", "loop".
[[nodiscard]] std::string subdivision_text(Scheme scheme, Weights weights);

}  // namespace planish::command
