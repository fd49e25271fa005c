#include "scene.h"

#include <filesystem>
#include <utility>

#include "options/scene_file.h"
#include "planish/backend/cpu_backend.h"
#include "planish/core/error.h"
#include "planish/job/job_input.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish::viewer {
namespace {

Job job_of(const std::string& path, const std::string& name) {
  if (std::filesystem::path(path).extension() == ".json") {
    std::vector<std::string> names;
    if (!name.empty()) names.push_back(name);
    auto jobs = command::select_jobs(command::read_scene_file(path), names);
    if (jobs.empty()) throw Error(ErrorCode::InvalidArgument, path + ": has no job to show");
    return std::move(jobs.front());
  }
  if (!name.empty())
    throw Error(ErrorCode::InvalidArgument, "--job " + name + ": " + path + " is no scene file");
  Job job;
  job.name = std::filesystem::path(path).stem().string();
  job.input = path;
  return job;
}

}  // namespace

Scene load_scene(const std::string& path, const std::string& name,
                 std::optional<InterpolationMethod> method) {
  const Job job = job_of(path, name);
  const Settings& settings = job.settings;
  if (settings.interpolation == InterpolationChoice::Fair &&
      method == InterpolationMethod::Progressive)
    throw Error(ErrorCode::InvalidArgument,
                job.name +
                    ": instances are of the progressive method, not of interpolation fair; "
                    "choose another job");
  if (settings.scheme != Scheme::DooSabin)
    throw Error(ErrorCode::InvalidArgument,
                job.name + ": scheme " + std::string(name_of(settings.scheme)) +
                    " is not drawn here, doo-sabin is; choose another job");
  InputFile file = load_input(job.input, job.input_format);
  file.split_normals_crease = job.settings.creases.split_normals;
  file.is_strict = job.settings.repair == RepairChoice::None;
  file.reach = job.settings.textures;
  Input input = mesh_of(file);
  if (settings.up == UpAxis::Z)
    for (glm::dvec3& p : input.file.mesh.positions) p = {p.x, p.z, -p.y};
  MeshFitOptions options = mesh_fit_options(settings);
  if (method) options.method = method;
  options.refine = RefineChoice::Off;  // its points are those that are dragged
  FittedMesh fitted =
      fit_prepared(prepare_mesh(std::move(input), options, settings),
                   *make_cpu_backend({.solve_precision = precision_for(settings.tolerance)}));
  Scene scene;
  scene.name = job.name;
  scene.mesh = std::move(fitted.mesh);
  scene.system.level = settings.levels.front();
  scene.system.method = fitted.options.method;
  scene.system.weights = settings.weights;
  scene.system.sharp = fitted.options.sharp;
  scene.system.within = fitted.options.within;
  scene.system.tolerance = settings.tolerance;
  if (fitted.fit.fair) {
    scene.decisions = std::make_shared<FairDecisions>(std::move(fitted.fit.fair->decisions));
    scene.system.fair_decisions = scene.decisions.get();
  }
  scene.settings = settings;
  scene.settings.creases.use_tags = scene.system.sharp.use_tags;  // the mesh has those that count
  scene.source = job.input;
  return scene;
}

}  // namespace planish::viewer
