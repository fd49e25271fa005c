#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "options/settings.h"
#include "planish/fair/interpolation_method.h"
#include "planish/mesh/prepared_mesh.h"
#include "planish/mesh/repair.h"
#include "planish/pipeline/found_creases.h"

namespace planish::command {

/// What changes a mesh on its way to the fit.
struct Preparation {
  RepairChoice repair = RepairChoice::Safe;
  CreaseChoice creases;
  InterpolationMethod method = InterpolationMethod::Progressive;
  std::optional<double> weld;
  /// Where no creases are to be found; of the mesh that comes out.
  std::span<const std::int32_t> smoothed_vertices;
};

/// A mesh to be fitted, with what was found of it. The lists of source vertices and faces are empty
/// where nothing was welded, repaired or cut.
struct ReadyMesh : RepairedMesh {
  std::int64_t welded_count = 0;
  /// Where creases were found for the fair method: how, for fit_with_found_creases().
  std::optional<FoundCreases> found;
  std::shared_ptr<const PreparedMesh> prepared;  ///< null where it cannot be used
};

/// The mesh that is fitted: without tags where they are to be ignored, welded where that is asked
/// for, repaired unless the choice is none, with creases detected where the
/// choice names an angle, and for fair surfaces, which fold beside corners that turn inward and
/// around tips of slits, with concave faces cut and such tips made corners where repair may. A mesh
/// that remains unusable comes back as it is, for require_usable() to refuse. Throws what repair()
/// throws, and then leaves `mesh` as it is, or welded.
[[nodiscard]] ReadyMesh prepare(PolygonMesh&& mesh, const Preparation& choice);

/// The same for a job, whose scene file may tag further edges and vertices of the input. Throws
/// Error{UnusableMesh} for a tag that names no vertex.
[[nodiscard]] ReadyMesh prepare(PolygonMesh&& mesh, const Settings& settings,
                                InterpolationMethod method);

}  // namespace planish::command
