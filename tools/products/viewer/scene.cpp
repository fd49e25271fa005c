#include "scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <numbers>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/job/job_input.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "scene_file.h"

namespace planish::viewer {
namespace {

constexpr double kPeriodSeconds = 7;
constexpr double kTwist = 0.7;    // radians between bottom and top
constexpr double kSway = 0.07;    // of the box's diagonal, at the top
constexpr double kBreath = 0.10;  // of the distance from the axis
constexpr double kWaves = 1.2;    // of breath along the height

}  // namespace

Animation::Animation(std::span<const glm::dvec3> rest)
    : rest_(rest.begin(), rest.end()), low_(std::numeric_limits<double>::max()), size_(0) {
  glm::dvec3 high(-low_);
  for (const glm::dvec3& p : rest_) {
    low_ = glm::min(low_, p);
    high = glm::max(high, p);
  }
  size_ = high - low_;
}

void Animation::pose(double seconds, std::span<glm::vec3> points) const {
  const double turn = 2 * std::numbers::pi, phase = turn * seconds / kPeriodSeconds;
  const glm::dvec3 middle = low_ + 0.5 * size_;
  const double diagonal = glm::length(size_);
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    // A flat shape lies at height 0 and only breathes.
    const double height = size_.y > 0 ? (rest_[i].y - low_.y) / size_.y : 0;
    const double angle = kTwist * height * std::sin(phase);
    const double scale = 1 + kBreath * std::sin(2 * phase) * std::cos(turn * kWaves * height);
    const glm::dvec3 arm = scale * (rest_[i] - middle);
    const double sway = kSway * diagonal * height * height * std::sin(phase);
    points[i] = {middle.x + std::cos(angle) * arm.x + std::sin(angle) * arm.z + sway, rest_[i].y,
                 middle.z - std::sin(angle) * arm.x + std::cos(angle) * arm.z};
  }
}

namespace {

constexpr float kFieldOfViewDegrees = 28;  // vertical; long enough to leave shapes undistorted
constexpr float kMargin = 1.02f;
constexpr float kLargestElevation = 89;  // above, "up" has no direction in the picture
constexpr float kDragDegrees = 220;      // for the picture's height
constexpr glm::vec3 kUp{0, 1, 0};

}  // namespace

glm::vec3 OrbitCamera::backward() const {
  const float azimuth = glm::radians(azimuth_degrees), elevation = glm::radians(elevation_degrees);
  return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
          std::cos(azimuth) * std::cos(elevation)};
}

float OrbitCamera::distance(float aspect) const {
  const float half_height = std::tan(glm::radians(kFieldOfViewDegrees / 2));
  const float half = std::atan(half_height * std::min(aspect, 1.0f));
  return kMargin * radius / std::sin(half) / zoom;
}

glm::vec3 OrbitCamera::eye(float aspect) const { return centre + distance(aspect) * backward(); }

glm::mat4 OrbitCamera::clip_from_world(float aspect) const {
  const float away = distance(aspect);
  const float near_plane = std::max(away - 1.5f * radius, 0.02f * away);
  glm::mat4 projection = glm::perspectiveRH_ZO(glm::radians(kFieldOfViewDegrees), aspect,
                                               near_plane, away + 1.5f * radius);
  projection[1][1] = -projection[1][1];
  return projection * glm::lookAtRH(eye(aspect), centre, kUp);
}

glm::vec3 OrbitCamera::key_light() const {
  const glm::vec3 right = glm::normalize(glm::cross(kUp, backward()));
  const glm::vec3 up = glm::cross(backward(), right);
  return glm::normalize(-0.55f * right + 0.65f * up + 0.65f * backward());
}

PictureRay OrbitCamera::ray_through(const glm::vec2& place, float aspect) const {
  const glm::dvec3 back(backward());
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(kUp), back));
  const glm::dvec3 up = glm::cross(back, right);
  const double half = std::tan(glm::radians(double{kFieldOfViewDegrees} / 2));
  const double x = (2.0 * place.x - 1) * half * aspect, y = (1 - 2.0 * place.y) * half;
  return {glm::dvec3(eye(aspect)), glm::normalize(x * right + y * up - back)};
}

std::optional<glm::vec2> OrbitCamera::place_of(const glm::dvec3& point, float aspect) const {
  const glm::vec4 clip = clip_from_world(aspect) * glm::vec4(glm::vec3(point), 1);
  if (!(clip.w > 0)) return std::nullopt;
  return 0.5f * (glm::vec2(clip) / clip.w + 1.0f);
}

glm::dvec3 OrbitCamera::moved_to(const glm::dvec3& point, const glm::vec2& place,
                                 float aspect) const {
  const PictureRay ray = ray_through(place, aspect);
  const glm::dvec3 back(backward());
  const double along = glm::dot(ray.direction, back);
  return ray.origin + ray.direction * (glm::dot(point - ray.origin, back) / along);
}

void OrbitCamera::orbit(float right, float down) {
  azimuth_degrees = std::remainder(azimuth_degrees - kDragDegrees * right, 360.0f);
  elevation_degrees =
      std::clamp(elevation_degrees + kDragDegrees * down, -kLargestElevation, kLargestElevation);
}

void OrbitCamera::zoom_by(float factor) {
  constexpr float kFarthest = 0.1f, kNearest = 20;
  zoom = std::clamp(zoom * factor, kFarthest, kNearest);
}

OrbitCamera camera_around(std::span<const glm::dvec3> points) {
  const auto [low, high] = point_bounds(points);
  OrbitCamera camera;
  camera.centre = 0.5 * (low + high);
  camera.radius = static_cast<float>(0.5 * glm::distance(low, high));
  return camera;
}

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
  job.name = utf8(std::filesystem::path(path).stem());
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
