#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/json_fwd.h"
#include "planish/measure/vertex_fields.h"
#include "planish/mesh/statistics.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish {

// What whoever gives a mesh should know of it, of its fit, its surface and its file, although all
// are made. Elements are counted as in the given mesh.

/// "torn-vertices" of a mesh that is ready: see torn_vertices(). None where somebody has welded it,
/// or sheets of it were separated: whoever did knows of vertices at one place.
[[nodiscard]] std::optional<Warning> torn_warning(const MeshToFit& ready, std::string_view name);

/// "not-converged" of a fit that misses its tolerance, with what helps.
[[nodiscard]] std::optional<Warning> convergence_warning(const FittedMesh& fitted,
                                                         std::string_view name);

/// "not-converged" and "unused-vertices" of a fitted mesh; with `of_input`, where the faces are the
/// caller's own, "inside-out", too.
[[nodiscard]] std::vector<Warning> mesh_warnings(const FittedMesh& fitted, std::string_view name,
                                                 bool of_input);

/// "folded-area" of a surface of which more than 1e-4 is folded, with what helps. `against_source`:
/// it was measured against another surface, not against the mesh's faces.
[[nodiscard]] std::optional<Warning> fold_warning(const FittedMesh& fitted,
                                                  const SurfaceQuality& quality,
                                                  bool against_source = false);

/// "sliding-texture" of a surface whose texture lies farther from where the input has it than
/// anybody would have it, with what helps. Distances are fractions of the diagonal.
[[nodiscard]] std::optional<Warning> slide_warning(const FittedMesh& fitted,
                                                   const TextureSlide& slide);

/// "rounded-output" of a file whose numbers keep an error above the tolerance, of the diagonal,
/// that the fit keeps.
[[nodiscard]] std::optional<Warning> rounding_warning(std::string_view output, double error,
                                                      double tolerance);

/// "large-output" of a file of a level that nobody named which is large, and many times its input.
[[nodiscard]] std::optional<Warning> size_warning(std::string_view output, std::uint64_t bytes,
                                                  std::uint64_t input_bytes, int level);

// What a report says of a fit, the same wherever it was made: the command, Python and ranks add
// what they alone know. Keys are those of src/planish/job/report.schema.json. Numbers that are
// infinite or none become null when the text is made.

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
