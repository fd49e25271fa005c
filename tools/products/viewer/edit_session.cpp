#include "edit_session.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <string>

#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/job/job_text.h"
#include "planish/solve/backend.h"

namespace planish::viewer {
namespace {

constexpr std::size_t kMostSteps = 256;  // that can be taken back

FitOptions edit_fit_options(const Scene& scene) {
  FitOptions options;
  options.weights = scene.system.weights;
  options.sharp = scene.system.sharp;
  options.tolerance = scene.system.tolerance;
  options.method = scene.system.method;
  options.fair_decisions = scene.system.fair_decisions;
  return options;
}

Fit fit_of(const Scene& scene) {
  return fit(scene.mesh, *make_cpu_backend(), edit_fit_options(scene));
}

EditorOptions editor_options(const Scene& scene) {
  EditorOptions options;
  options.level = 0;       // the device makes the rows that are drawn
  options.undo_steps = 0;  // a drag of many moves is one step here
  options.fit = edit_fit_options(scene);
  return options;
}

double distance_to_edge(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 along = b - a;
  const double square = glm::dot(along, along);
  const double t = square > 0 ? std::clamp(glm::dot(p - a, along) / square, 0.0, 1.0) : 0;
  return glm::distance(p, a + t * along);
}

}  // namespace

EditSession::EditSession(const Scene& scene)
    : mesh_(scene.mesh),
      decisions_(scene.decisions),
      fit_(fit_of(scene)),
      editor_(mesh_, fit_, editor_options(scene)) {}

PolygonMesh EditSession::rest() const {
  PolygonMesh mesh = editor_.mesh();
  const auto rest = editor_.rest_positions();
  mesh.positions.assign(rest.begin(), rest.end());
  return mesh;
}

std::optional<SurfaceHit> EditSession::hit(const SurfaceRay& ray) {
  return editor_.queries().first_hit(ray);
}

std::optional<std::int32_t> EditSession::pick(const SurfaceRay& ray) {
  const auto found = hit(ray);
  if (!found) return std::nullopt;
  return *std::ranges::min_element(mesh_.face(found->at.face), {}, [&](std::int32_t v) {
    return glm::distance(points()[v], found->position);
  });
}

std::optional<std::pair<std::int32_t, std::int32_t>> EditSession::pick_edge(const SurfaceRay& ray) {
  const auto found = hit(ray);
  if (!found) return std::nullopt;
  const auto face = mesh_.face(found->at.face);
  std::pair<std::int32_t, std::int32_t> nearest;
  double least = std::numeric_limits<double>::max();
  for (std::size_t k = 0; k < face.size(); ++k) {
    const std::int32_t a = face[k], b = face[(k + 1) % face.size()];
    const double distance = distance_to_edge(found->position, points()[a], points()[b]);
    if (distance >= least) continue;
    least = distance;
    nearest = std::minmax(a, b);
  }
  return nearest;
}

void EditSession::select(std::vector<std::int32_t> vertices) {
  for (const std::int32_t vertex : vertices) {
    if (vertex >= 0 && vertex < mesh_.vertex_count()) continue;
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("there is no vertex {}; the mesh has 0 to {}", vertex, mesh_.vertex_count() - 1),
        vertex);
  }
  selected_ = std::move(vertices);
}

void EditSession::toggle(std::int32_t vertex) {
  std::vector<std::int32_t> now = selected_;
  if (std::erase(now, vertex) == 0) now.push_back(vertex);
  select(std::move(now));
}

bool EditSession::is_selected(std::int32_t vertex) const {
  return std::ranges::find(selected_, vertex) != selected_.end();
}

void EditSession::set_radius(double radius) {
  if (!(radius >= 0) || !std::isfinite(radius))
    throw Error(ErrorCode::InvalidArgument, "the radius " + std::to_string(radius) +
                                                " is no length; 0 moves the selection alone");
  radius_ = radius;
}

Selection EditSession::reached() const {
  if (drag_) return drag_->moved;  // those that were near when it began
  if (radius_ > 0 && !selected_.empty()) return editor_.select(selected_, radius_);
  return {selected_, std::vector<double>(selected_.size(), 1.0)};
}

void EditSession::begin_drag() {
  if (selected_.empty())
    throw Error(ErrorCode::InvalidArgument, "nothing is selected; pick a vertex first");
  Drag drag{reached(), {}};
  drag.before.vertices = drag.moved.vertices;
  for (const std::int32_t v : drag.moved.vertices) drag.before.positions.push_back(points()[v]);
  drag_ = std::move(drag);
}

void EditSession::drag_to(const glm::dvec3& way) {
  if (!drag_) begin_drag();
  std::vector<glm::dvec3> to = drag_->before.positions;
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += drag_->moved.weights[i] * way;
  editor_.move(drag_->moved.vertices, to);
}

void EditSession::end_drag() {
  if (!drag_) return;
  Step before = std::move(drag_->before);
  drag_.reset();
  // A click that moves nothing is no step.
  for (std::size_t i = 0; i < before.vertices.size(); ++i) {
    if (points()[before.vertices[i]] == before.positions[i]) continue;
    add(std::move(before));
    return;
  }
}

void EditSession::toggle_crease(std::int32_t v0, std::int32_t v1) {
  const auto is_it = [&](const CreaseEdge& c) {
    return std::minmax(c.v0, c.v1) == std::minmax(v0, v1) && c.sharpness >= kInfiniteSharpness;
  };
  const bool is_sharp = std::ranges::any_of(editor_.mesh().creases, is_it);
  Step step;
  step.creases.push_back({v0, v1, is_sharp ? 0 : kInfiniteSharpness});
  add(apply(step));
}

void EditSession::toggle_corner(std::int32_t vertex) {
  const auto is_it = [&](const CornerVertex& c) {
    return c.vertex == vertex && c.sharpness >= kInfiniteSharpness;
  };
  const bool is_sharp = std::ranges::any_of(editor_.mesh().corners, is_it);
  Step step;
  step.corners.push_back({vertex, is_sharp ? 0 : kInfiniteSharpness});
  add(apply(step));
}

// Returns the step back.
EditSession::Step EditSession::apply(const Step& step) {
  Step before;
  if (!step.vertices.empty()) {
    before.vertices = step.vertices;
    for (const std::int32_t v : step.vertices) before.positions.push_back(points()[v]);
    editor_.move(step.vertices, step.positions);
    return before;
  }
  const auto other = [](float sharpness) { return sharpness > 0 ? 0 : kInfiniteSharpness; };
  before = step;
  for (CreaseEdge& crease : before.creases) crease.sharpness = other(crease.sharpness);
  for (CornerVertex& corner : before.corners) corner.sharpness = other(corner.sharpness);
  editor_.set_sharp(step.creases, step.corners);
  ++revision_;
  return before;
}

void EditSession::add(Step&& before) {
  future_.clear();
  past_.push_back(std::move(before));
  if (past_.size() > kMostSteps) past_.pop_front();
}

bool EditSession::take(std::deque<Step>& from, std::deque<Step>& to) {
  end_drag();
  if (from.empty()) return false;
  to.push_back(apply(from.back()));
  from.pop_back();
  return true;
}

bool EditSession::undo() { return take(past_, future_); }
bool EditSession::redo() { return take(future_, past_); }

namespace {

constexpr float kHandle = 0.015f;  // how far beside the surface one is taken, of the height

SurfaceRay surface_ray(const OrbitCamera& camera, float aspect, const glm::vec2& place) {
  const PictureRay ray = camera.ray_through(place, aspect);
  return {ray.origin, ray.direction};
}

}  // namespace

std::optional<std::int32_t> EditHand::vertex_at(const OrbitCamera& camera, float aspect,
                                                const glm::vec2& place) {
  if (const auto vertex = session_.pick(surface_ray(camera, aspect, place))) return vertex;
  std::optional<std::int32_t> nearest;
  float least = kHandle;
  const auto points = session_.points();
  for (std::size_t v = 0; v < points.size(); ++v) {
    const auto at = camera.place_of(points[v], aspect);
    if (!at) continue;
    const float distance = glm::length((*at - place) * glm::vec2(aspect, 1));
    if (distance >= least) continue;
    least = distance;
    nearest = static_cast<std::int32_t>(v);
  }
  return nearest;
}

std::optional<std::int32_t> EditHand::press(const OrbitCamera& camera, float aspect,
                                            const glm::vec2& place, bool adds) {
  release();
  const auto vertex = vertex_at(camera, aspect, place);
  if (!vertex) return std::nullopt;
  if (adds) {
    session_.toggle(*vertex);
    return vertex;
  }
  if (!session_.is_selected(*vertex)) session_.select({*vertex});
  const glm::dvec3 start = session_.points()[*vertex];
  held_ = Held{start, place, camera.place_of(start, aspect).value_or(place)};
  return vertex;
}

void EditHand::drag(const OrbitCamera& camera, float aspect, const glm::vec2& place) {
  if (!held_ || (!held_->has_moved && place == held_->from)) return;
  if (!held_->has_moved) session_.begin_drag();
  held_->has_moved = true;
  // The vertex keeps its way from the cursor, so that it does not jump when it is taken.
  const glm::vec2 to = held_->handle + (place - held_->from);
  session_.drag_to(camera.moved_to(held_->start, to, aspect) - held_->start);
}

void EditHand::release() {
  if (held_ && held_->has_moved) session_.end_drag();
  held_.reset();
}

bool EditHand::toggle_crease(const OrbitCamera& camera, float aspect, const glm::vec2& place) {
  const auto edge = session_.pick_edge(surface_ray(camera, aspect, place));
  if (!edge) return false;
  session_.toggle_crease(edge->first, edge->second);
  return true;
}

namespace {

// Scenes are shown with y up; files have the axes of the input.
void turn_back(const SaveOptions& options, PolygonMesh& mesh) {
  if (options.settings.up != UpAxis::Z) return;
  for (glm::dvec3& p : mesh.positions) p = {p.x, -p.z, p.y};
}

FileFormat format_for(const std::filesystem::path& path, SavedPart part) {
  const auto format = format_of(path);
  const bool is_surface = part == SavedPart::Surface;
  if (format && (is_surface ? info_of(*format).is_gltf : serves(*format, FormatUse::WriteMesh)))
    return *format;
  throw Error(ErrorCode::InvalidArgument,
              utf8(path) + (is_surface ? ": surfaces are saved as .glb or .gltf"
                                       : ": meshes and cages are saved as " +
                                             extensions_in_words(FormatUse::WriteMesh)));
}

void save_surface(const EditSession& session, const std::filesystem::path& path,
                  const SaveOptions& options) {
  GltfOptions gltf;
  gltf.name = utf8(std::filesystem::path(options.source).stem());
  if (gltf.name.empty()) gltf.name = "surface";
  write_gltf(path, *session.editor().blocks(options.level), gltf);
}

}  // namespace

SaveOptions save_options(const Scene& scene) {
  return {scene.settings, scene.source, scene.system.level};
}

void save(const EditSession& session, SavedPart part, const std::filesystem::path& path,
          const SaveOptions& options) {
  const FileFormat format = format_for(path, part);
  if (part == SavedPart::Surface) return save_surface(session, path, options);
  PolygonMesh mesh = session.editor().mesh();
  MeshWriteOptions write;
  write.is_z_up = options.settings.up == UpAxis::Z;
  if (part == SavedPart::Cage) {
    const FitSettings& settings = options.settings;
    const Fit fit = session.editor().fit();
    mesh = control_cage(mesh, fit, settings.sharp());
    write.header = cage_header_lines(
        settings, fit.fair ? InterpolationMethod::Fair : InterpolationMethod::Progressive,
        options.source);
    write.subdivision.has_sharp_boundary_corners = settings.boundary == BoundaryRule::EdgeAndCorner;
  }
  turn_back(options, mesh);
  write_mesh(path, format, mesh, write);
}

std::string save_all(const EditSession& session, const std::string& prefix,
                     const SaveOptions& options) {
  const std::string mesh = prefix + ".obj", cage = prefix + "_cage.obj", surface = prefix + ".glb";
  save(session, SavedPart::Mesh, mesh, options);
  save(session, SavedPart::Cage, cage, options);
  save(session, SavedPart::Surface, surface, options);
  return "saved " + mesh + ", " + cage + ", " + surface;
}

}  // namespace planish::viewer
