#pragma once

#include <span>

#include "planish/core/json_fwd.h"
#include "planish/mesh/statistics.h"
#include "planish/pipeline/fit_mesh.h"

// What a report says of a fit, the same wherever it was made: the command, Python and ranks add
// what they alone know. Keys are those of src/planish/job/report.schema.json. Numbers that are
// infinite or none become null when the text is made.
namespace planish {

/// The mesh that was fitted: `input` of a report.
/// `folded_edges`: see FoldedEdges, as the area.
[[nodiscard]] nlohmann::ordered_json input_json(const FitFigures& fit,
                                                const MeshStatistics& statistics,
                                                std::int64_t folded_edges, double folded_edge_area);

/// Options and result of the fit: `solve` of a report.
[[nodiscard]] nlohmann::ordered_json solve_json(const FitFigures& fit);

/// The figures of a level: most of `surface`.
[[nodiscard]] nlohmann::ordered_json quality_json(const SurfaceQuality& quality, int level);

[[nodiscard]] nlohmann::ordered_json warnings_json(std::span<const Warning> warnings);

}  // namespace planish
