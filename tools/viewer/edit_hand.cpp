#include "edit_hand.h"

#include <glm/geometric.hpp>

namespace planish::viewer {
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

}  // namespace planish::viewer
