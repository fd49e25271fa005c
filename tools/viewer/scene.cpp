#include "scene.h"

#include <filesystem>
#include <utility>

#include "job/job_input.h"
#include "options/scene_file.h"
#include "planish/core/error.h"

namespace planish::viewer {
namespace {

command::Job job_of(const std::string& path, const std::string& name) {
  if (std::filesystem::path(path).extension() == ".json") {
    std::vector<std::string> names;
    if (!name.empty()) names.push_back(name);
    auto jobs = command::select_jobs(command::read_scene_file(path), names);
    if (jobs.empty()) throw Error(ErrorCode::InvalidArgument, path + ": has no job to show");
    return std::move(jobs.front());
  }
  if (!name.empty())
    throw Error(ErrorCode::InvalidArgument, "--job " + name + ": " + path + " is no scene file");
  command::Job job;
  job.name = std::filesystem::path(path).stem().string();
  job.input = path;
  return job;
}

}  // namespace

Scene load_scene(const std::string& path, const std::string& name) {
  const command::Job job = job_of(path, name);
  const command::Settings& settings = job.settings;
  if (settings.interpolation == InterpolationChoice::Fair)
    throw Error(
        ErrorCode::InvalidArgument,
        job.name + ": interpolation fair is not drawn here, progressive is; choose another job");
  if (settings.scheme != Scheme::DooSabin)
    throw Error(ErrorCode::InvalidArgument,
                job.name + ": scheme " + std::string(command::name_of(settings.scheme)) +
                    " is not drawn here, doo-sabin is; choose another job");
  command::InputFile file = command::load_input(job.input, job.input_format);
  file.split_normals_crease = job.settings.creases.split_normals;
  file.is_strict = job.settings.repair == RepairChoice::None;
  command::Input input = command::mesh_of(file);
  Scene scene;
  scene.name = job.name;
  MeshFitOptions options = mesh_fit_options(settings);
  options.method = InterpolationMethod::Progressive;
  scene.mesh = command::prepare_mesh(std::move(input), options, settings).fitted.mesh;
  if (settings.up == UpAxis::Z)
    for (glm::dvec3& p : scene.mesh.positions) p = {p.x, p.z, -p.y};
  scene.system.level = settings.levels.front();
  scene.system.weights = settings.weights;
  scene.system.sharp = settings.sharp();
  scene.system.tolerance = settings.tolerance;
  scene.settings = settings;
  scene.source = job.input;
  return scene;
}

}  // namespace planish::viewer
