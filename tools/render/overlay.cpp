#include "overlay.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace planish::render {
namespace {

// A round dot, entered where it is nearer than what is there.
void draw_dot(const glm::vec3& at, float width, std::uint32_t what, VisibilityBuffer& buffer) {
  const float radius = width / 2;
  const int x0 = std::max(0, static_cast<int>(at.x - radius));
  const int x1 = std::min(buffer.width - 1, static_cast<int>(at.x + radius));
  const int y0 = std::max(0, static_cast<int>(at.y - radius));
  const int y1 = std::min(buffer.height - 1, static_cast<int>(at.y + radius));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const glm::vec2 d(static_cast<float>(x) + 0.5f - at.x, static_cast<float>(y) + 0.5f - at.y);
      const std::size_t sample = buffer.at(x, y);
      if (glm::dot(d, d) > radius * radius || at.z <= buffer.nearness[sample]) continue;
      buffer.nearness[sample] = at.z;
      buffer.what[sample] = what;
    }
  }
}

}  // namespace

void draw_overlay(const PolygonMesh& mesh, const Camera& camera, const OverlayOptions& options,
                  VisibilityBuffer& buffer) {
  std::vector<glm::vec3> projected;
  for (const glm::dvec3& p : mesh.positions) {
    glm::vec3 at = camera.project(glm::vec3(p));
    at.z *= 1 + options.lift;
    projected.push_back(at);
  }
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const glm::vec3 a = projected[face[i]], b = projected[face[(i + 1) % face.size()]];
      const int steps = static_cast<int>(glm::distance(glm::vec2(a), glm::vec2(b))) + 1;
      for (int s = 0; options.edge_width > 0 && s <= steps; ++s) {
        const float t = static_cast<float>(s) / static_cast<float>(steps);
        draw_dot(a + t * (b - a), options.edge_width, kEdgeSample, buffer);
      }
    }
  }
  if (options.vertex_width <= 0) return;
  for (const glm::vec3& at : projected) {
    // A little nearer than the edges that end there.
    draw_dot({at.x, at.y, at.z * (1 + options.lift)}, options.vertex_width, kVertexSample, buffer);
  }
}

}  // namespace planish::render
