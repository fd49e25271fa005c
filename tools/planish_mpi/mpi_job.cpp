#include "mpi_job.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "mpi_options.h"
#include "planish/core/error.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/job/cage_header.h"
#include "planish/job/text.h"
#include "planish/pipeline/make_ready.h"

namespace planish::command {
namespace {

void take_output(const OutputRequest& request, MpiJob& job) {
  const auto format = format_of(request.path);
  const bool is_cage = request.kind == OutputKind::Cage;
  if (is_cage && format != FileFormat::Ply)
    refuse(request.where, visible(request.path) + ": ranks write cages as .ply only");
  if (!is_cage && (!format || !info_of(*format).is_tiles))
    refuse(request.where,
           visible(request.path) +
               ": ranks write surfaces as 3D Tiles (.json) only; take NAME.json, or planish on one "
               "machine");
  std::string& path = is_cage ? job.cage : job.tiles;
  if (!path.empty())
    refuse(request.where, visible(request.path) + ": ranks write one " +
                              (is_cage ? "cage" : "set of tiles") + " of a mesh, and there is " +
                              visible(path) + " already; make two jobs of it");
  path = request.path;
  job.outputs.push_back(request);
  if (is_cage) return;
  if (request.adaptive.any())
    refuse(request.where, visible(request.path) +
                              ": 3D Tiles have levels, not a chord error or an angle; take levels");
  job.options.tiles_options.level = std::ranges::max(request.levels);
  if (job.options.tiles_options.level < 1)
    refuse(request.where == "-o" ? "--levels" : request.where,
           visible(request.path) + ": 3D Tiles have levels from 1 on, not 0");
}

void take_settings(MpiJob& job) {
  const Settings& settings = job.settings;
  DistributedOptions& options = job.options;
  options.method = settings.interpolation == InterpolationChoice::Fair
                       ? InterpolationMethod::Fair
                       : InterpolationMethod::Progressive;
  options.polish_steps = settings.polish_steps;
  options.weights = settings.weights;
  options.sharp = {settings.boundary, settings.creases.use_tags};
  options.crease_edges = settings.crease_edges;
  options.corner_vertices = settings.corner_vertices;
  options.solver = settings.solver;
  options.tolerance = settings.tolerance;
  options.within = settings.within.of_diagonal.value_or(0.0);
  options.max_iterations = settings.max_iterations;
  job.settings.quads = QuadChoice::Off;
  job.settings.refine = RefineChoice::Off;
  options.creases = creases_text(settings.creases.use_tags, false, {});
  TilesOptions& tiles = options.tiles_options;
  tiles.tile_vertices = settings.tile_vertices;
  tiles.skirts = settings.skirts;
  tiles.gltf.z_up = settings.up == UpAxis::Z;
}

bool is_given(const Job& job, std::string_view name) {
  return std::ranges::find(job.given, name, &GivenSetting::name) != job.given.end();
}

}  // namespace

MpiJob mpi_job_of(const Job& job, const MpiSettings& own) {
  require_available(job.given, job.settings);
  MpiJob made;
  made.name = job.name;
  made.input = job.input;
  made.input_format = job.input_format;
  made.settings = job.settings;
  // Nothing is mended over ranks: what planish does by itself is not refused, but left out.
  if (!is_given(job, "repair")) made.settings.repair = RepairChoice::None;
  if (job.input == "-")
    refuse("INPUT", "stdin cannot be read in ranges; write it to a file, and name that");
  for (const OutputRequest& request : job.outputs) take_output(request, made);
  take_settings(made);
  DistributedOptions& options = made.options;
  options.name = job.input;
  options.tiles = made.tiles;
  options.cage = made.cage;
  options.resume = own.resume && !made.tiles.empty();
  options.replaces = own.force;
  options.tiles_options.gltf.name = plain_utf8(std::filesystem::path(job.input).stem().string());
  options.cage_header = cage_header_lines(made.settings, options.method, job.input);
  if (own.block_vertices) options.block_vertices = *own.block_vertices;
  made.report = job.report;
  return made;
}

void claim_files(const std::vector<MpiJob>& jobs, const std::string& scene,
                 const MpiSettings& own) {
  PathClaims claims({.overwrite = own.force, .create_folders = own.is_scene});
  if (!scene.empty()) claims.add_input(scene);
  for (const MpiJob& job : jobs) claims.add_input(job.input);
  for (const MpiJob& job : jobs) {
    for (const OutputRequest& request : job.outputs) (void)plan_output(request, claims);
    if (!job.report.empty())
      claims.add_report(job.report, own.is_scene ? "report of job " + job.name : "--report");
  }
}

std::vector<PlannedStep> steps_of(const MpiJob& job) {
  // Seconds of 4 million vertices, and of tiles of level 2.
  const bool is_fair = job.options.method == InterpolationMethod::Fair;
  const double tiles =
      job.tiles.empty() ? 0 : 1.25 * std::ldexp(1.0, 2 * job.options.tiles_options.level);
  return {{"read", 0.5},    {"sort", 1.6}, {"faces", 0.4},
          {"rings", 0.3},   {"rows", 2.1}, {"solve", is_fair ? 55.0 : 0.6},
          {"tiles", tiles}, {"write", 0.5}};
}

void make_folders(const MpiJob& job) {
  for (const std::string& path : {job.tiles, job.cage, job.report}) {
    if (path.empty() || path == "-") continue;
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error)
      throw Error(ErrorCode::UnwritableOutput,
                  formatted("{}: cannot make the folder {}: {}", visible(path),
                            visible(folder.string()), error.message()));
  }
}

}  // namespace planish::command
