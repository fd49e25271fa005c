#include "edit_overlay.h"

#include <imgui.h>

namespace planish::viewer {
namespace {

constexpr ImU32 kHandleInk = IM_COL32(255, 170, 30, 255), kHandleRim = IM_COL32(60, 40, 10, 255),
                kAlongInk = IM_COL32(255, 170, 30, 150);
constexpr std::size_t kMostDots = 300;  // of those that move along: more hide the surface
// Of the picture's height.
constexpr float kHandleSize = 0.0095f, kAlongSize = 0.0055f, kLeastAlong = 0.25f;

}  // namespace

void draw_selection(const EditSession& session, const OrbitCamera& camera, const glm::vec2& size) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float aspect = size.x / size.y;
  const auto points = session.points();
  const Selection reached = session.reached();
  const auto draw = [&](std::int32_t vertex, float radius, ImU32 ink, bool has_rim) {
    const auto place = camera.place_of(points[vertex], aspect);
    if (!place) return;
    const ImVec2 at{place->x * size.x, place->y * size.y};
    list.AddCircleFilled(at, radius * size.y, ink);
    if (has_rim) list.AddCircle(at, radius * size.y, kHandleRim, 0, 0.2f * radius * size.y);
  };
  const std::size_t stride = (reached.vertices.size() + kMostDots - 1) / kMostDots;
  for (std::size_t i = 0; i < reached.vertices.size(); i += stride) {
    const auto weight = static_cast<float>(reached.weights[i]);
    if (weight < 1)
      draw(reached.vertices[i], kAlongSize * (kLeastAlong + (1 - kLeastAlong) * weight), kAlongInk,
           false);
  }
  for (const std::int32_t vertex : session.selected()) draw(vertex, kHandleSize, kHandleInk, true);
}

}  // namespace planish::viewer
