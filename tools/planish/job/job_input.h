#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "job/input.h"
#include "job/job.h"
#include "job/prepare.h"
#include "planish/core/callbacks.h"
#include "planish/mesh/folded_edges.h"
#include "planish/mesh/prepared_mesh.h"

namespace planish::command {

/// Says a warning once and keeps it for the report.
void add_warning(JobReport& report, Console& console, const Warning& warning);

/// The library's way to talk to a job's progress, report and interrupts. Both must outlive it.
[[nodiscard]] Callbacks callbacks_for(JobReport& report, const JobContext& context);

/// A mesh, or points with the mesh that was made of them.
struct JobInput {
  Input input;
  std::vector<glm::dvec3> points;                ///< that were used, where the file has them
  std::optional<Input> source;                   ///< where the job names one
  std::shared_ptr<const PreparedMesh> prepared;  ///< of the mesh; null where it cannot be used
  /// For each vertex of the mesh the file's that it is or copies; empty: the same.
  std::vector<std::int32_t> file_vertices;
  std::vector<std::int32_t> file_faces;  ///< the same of faces
  /// Of the file's vertices, where repair separated sheets.
  std::vector<std::pair<std::int32_t, std::int32_t>> separated_edges;
  std::optional<FoundCreases> found;  ///< how creases were, of a fair surface's mesh
  /// As the file has it, where measurement chooses the method.
  std::optional<PolygonMesh> unprepared;
  FoldedEdges folds;  ///< of the mesh, once it is fitted
};

/// Reads a job's input, meshing points, and its source, and notes in the report what the file is.
/// Throws planish::Error.
[[nodiscard]] JobInput read_job_input(const Job& job, JobReport& report, const JobContext& context);

/// Whether a mesh's method is chosen by measurement: not where it is named, where only one is to be
/// had, or where a cage is wanted, which the progressive method alone makes of the mesh's faces.
[[nodiscard]] bool chooses_by_measurement(const Settings& settings,
                                          const std::vector<PlannedOutput>& outputs);

/// Settles the report's method, unless measurement will choose it, then welds and repairs the mesh
/// and tags its creases as the job's settings say; repairs are told as warnings, since the file is
/// not what its author believes. Throws Error{UnusableMesh} naming the file.
void prepare_input(JobInput& made, const std::vector<PlannedOutput>& outputs, JobReport& report,
                   Console& console);

/// The mesh of the fair surface in place of the one that is there.
void take_fair_mesh(JobInput& made, PolygonMesh&& mesh, ReadyMesh&& ready, JobReport& report,
                    Console& console);

/// Warns "unused-settings" of flags that have no effect on what the input turned out to be.
void warn_of_unused_settings(const Job& job, const JobInput& made, JobReport& report,
                             Console& console);

}  // namespace planish::command
