#pragma once

#include <chrono>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/materials.h"
#include "planish/job/input.h"
#include "planish/job/job.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish {

/// Runs `work` and adds the milliseconds it took to `total`.
template <class Work>
auto timed(double& total, const Work& work) {
  struct Stopwatch {
    double& total;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    ~Stopwatch() {
      total += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                   .count();
    }
  } stopwatch{total};
  return work();
}

/// What a job's steps share.
struct JobContext {
  const JobWatch& watch;
  JobProgress& progress;
  JobPage* page = nullptr;  ///< that is made, or takes a part of the job

  [[nodiscard]] bool wants_page() const { return page != nullptr; }
};

/// Says a warning once and keeps it for the report.
void add_warning(JobReport& report, const JobContext& context, const Warning& warning);

/// The library's way to talk to a job's progress, report and interrupts. Both must outlive it.
[[nodiscard]] Callbacks callbacks_for(JobReport& report, const JobContext& context);

/// A mesh, or points with the mesh that was made of them.
struct JobInput {
  Input input;
  std::vector<glm::dvec3> points;  ///< that were used, where the file has them
  PolygonMesh scan;                ///< Reconstruction::scan of these, for STEP
  FileMaterials materials;         ///< that the file names
  std::optional<Input> source;     ///< where the job names one
  FittedMesh fitted;               ///< the mesh of `input`, once fit_input() has it
  std::optional<FittedMesh> cage;  ///< what a control cage is of, where that is another fit
  FoldedEdges folds;               ///< of that
};

/// Loads the file of a job's input, to be read as the job's settings say. Throws as load_input().
[[nodiscard]] InputFile load_job_input(const Job& job, JobReport& report,
                                       const JobContext& context);

/// Whether a job's input holds points, by its format, of a PLY file, which may hold either, by its
/// head. Of stdin only the format tells.
[[nodiscard]] bool may_be_points(const Job& job);

/// Throws Error{OutOfMemory} where an input has more points than the job's limits allow.
void require_points(const Job& job, const std::string& name, std::int64_t count);

/// Reads a job's input, meshing points, and its source, and notes in the report what the file is.
/// Throws planish::Error.
[[nodiscard]] JobInput read_job_input(const Job& job, const InputFile& file, JobReport& report,
                                      const JobContext& context);

/// Whether a mesh's method is chosen by measurement: not where it is named, or where only one is to
/// be had.
[[nodiscard]] bool chooses_by_measurement(const Settings& settings);

/// Where anything is left open and a cage is written, its fit: see cage_fit(). What the surface
/// is does not hang on it, but where nothing else shows one (`has_page`: a page does): then it
/// takes the place of `ready`, and nothing is given.
/// Nothing, too, where the cage is of another scheme: see fit_cage_in_scheme().
[[nodiscard]] std::optional<ReadyFit> take_cage(ReadyFit& ready, const Settings& settings,
                                                const std::vector<PlannedOutput>& outputs,
                                                bool has_page);

/// What prepare_fit() makes of the input's mesh with the tags that a scene adds. Throws as that,
/// and Error{UnusableMesh} for a tag that names no vertex.
[[nodiscard]] ReadyFit prepare_mesh(Input&& input, MeshFitOptions options,
                                    const Settings& settings);

/// prepare_fit() of the input's mesh, with the tags that a scene adds, as the job's settings say;
/// repairs are told as warnings, since the file is not what its author believes. Notes the report's
/// method, which measurement may still change. Throws Error{UnusableMesh} naming the file.
[[nodiscard]] ReadyFit prepare_input(JobInput& made, JobReport& report, const JobContext& context);

/// Warns "unused-settings" of flags that have no effect on what the input turned out to be.
void warn_of_unused_settings(const Job& job, const JobInput& made, JobReport& report,
                             const JobContext& context);

/// fit_prepared() into `made` and the moves of its vertices, noted in the report: figures, times,
/// and exit code 5 with a warning where the solve does not converge. Throws as that.
void fit_input(JobInput& made, ReadyFit&& ready, Backend& backend, std::span<const SceneMove> moves,
               JobReport& report, const JobContext& context);

/// The same of a control cage, after it, into JobInput::cage; nothing where the surface has that
/// cage itself.
void fit_cage(JobInput& made, ReadyFit&& ready, Backend& backend, std::span<const SceneMove> moves,
              JobReport& report, const JobContext& context);

/// The same where Settings::cage_scheme is not that of the surface: see cage_in_scheme(). Vertices
/// have moved before.
void fit_cage_in_scheme(JobInput& made, Backend& backend, JobReport& report,
                        const JobContext& context);

}  // namespace planish
