// Each lamp is far away: the mesh is drawn once into a depth map for each, and points behind what
// the lamp sees are in its shadow.
#include "dome_light.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "planish/core/parallel.h"
#include "planish/core/point_bounds.h"
#include "planish/job/page/rasterise.h"

namespace planish::render {
namespace {

constexpr int kMapSize = 640;
constexpr int kRoomLamps = 192, kKeyLamps = 64, kFillLamps = 24;
constexpr float kKeyPower = 1.0f, kFillPower = 0.2f, kRoomPower = 0.32f;
constexpr float kFloorBrightness = 0.55f;  // of the room's ceiling
constexpr float kGoldenAngle = 2.399963f;
// Texels by which a point is lifted off its own surface.
constexpr float kBias = 2.0f;

struct Frame {
  glm::vec3 u, v, w;
};

Frame frame_about(const glm::vec3& w) {
  const glm::vec3 helper = std::abs(w.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
  const glm::vec3 u = glm::normalize(glm::cross(helper, w));
  return {u, glm::cross(w, u), w};
}

}  // namespace

DomeLight::DomeLight(const RenderMesh& mesh, const Camera& camera) : mesh_(mesh) {
  const auto [low, high] = point_bounds(mesh.positions);
  centre_ = 0.5f * (low + high);
  radius_ = 0.5f * glm::distance(low, high);
  const glm::vec3 back = -camera.forward;
  key_ = glm::normalize(back * 0.65f - camera.right * 0.6f + glm::vec3(0, 0.95f, 0));
  add_cone(key_, 16, kKeyLamps, kKeyPower);
  add_cone(glm::normalize(back * 0.4f + camera.right + glm::vec3(0, 0.25f, 0)), 20, kFillLamps,
           kFillPower);
  for (int i = 0; i < kRoomLamps; ++i) {
    const float y = 1 - 2 * (static_cast<float>(i) + 0.5f) / kRoomLamps;
    const float r = std::sqrt(1 - y * y), angle = kGoldenAngle * static_cast<float>(i);
    const float brightness = glm::mix(kFloorBrightness, 1.0f, glm::smoothstep(-0.2f, 0.6f, y));
    // An even dome of power 4 / n a lamp lights a free point with 1.
    lamps_.push_back(
        {{r * std::cos(angle), y, r * std::sin(angle)}, kRoomPower * brightness * 4 / kRoomLamps});
  }
  unit_ = 1 / free_irradiance(key_);
}

void DomeLight::add_cone(const glm::vec3& axis, float half_angle_degrees, int count, float power) {
  const Frame frame = frame_about(axis);
  const float spread = std::tan(glm::radians(half_angle_degrees));
  for (int i = 0; i < count; ++i) {
    const float r = spread * std::sqrt((static_cast<float>(i) + 0.5f) / static_cast<float>(count));
    const float angle = kGoldenAngle * static_cast<float>(i);
    lamps_.push_back(
        {glm::normalize(axis + r * (std::cos(angle) * frame.u + std::sin(angle) * frame.v)),
         power / static_cast<float>(count)});
  }
}

float DomeLight::free_irradiance(const glm::vec3& normal) const {
  float sum = 0;
  for (const Lamp& lamp : lamps_) {
    sum += lamp.power * std::max(0.0f, glm::dot(normal, lamp.direction));
  }
  return sum * unit_;
}

std::vector<float> DomeLight::irradiance(const std::vector<LitPoint>& points) const {
  // Summed in lamp order, so that the picture does not depend on the threads.
  std::vector<float> sum(points.size());
  const float texel = 2 * radius_ / (kMapSize - 4);
  for (const Lamp& lamp : lamps_) {
    const Frame frame = frame_about(lamp.direction);
    const auto to_map = [&](const glm::vec3& p) {
      const glm::vec3 d = p - centre_;
      return glm::vec3(glm::dot(d, frame.u) / texel + kMapSize / 2.0f,
                       glm::dot(d, frame.v) / texel + kMapSize / 2.0f, glm::dot(d, frame.w));
    };
    std::vector<glm::vec3> projected(mesh_.positions.size());
    parallel_each(projected.size(), 4096,
                  [&](std::size_t i) { projected[i] = to_map(mesh_.positions[i]); });
    VisibilityBuffer map(kMapSize, kMapSize);
    constexpr int kBandRows = kMapSize / 4;
    parallel_for(kMapSize / kBandRows, 1, [&](std::size_t begin, std::size_t end) {
      rasterise(projected, mesh_.indices, static_cast<int>(begin) * kBandRows,
                static_cast<int>(end) * kBandRows, map);
    });
    parallel_each(points.size(), 4096, [&](std::size_t i) {
      const float cosine = glm::dot(points[i].normal, lamp.direction);
      if (cosine <= 0) return;
      const glm::vec3 at = to_map(points[i].position + kBias * texel * points[i].normal);
      const int x = static_cast<int>(std::floor(at.x - 0.5f));
      const int y = static_cast<int>(std::floor(at.y - 0.5f));
      float seen = 1;
      if (x >= 0 && y >= 0 && x + 1 < kMapSize && y + 1 < kMapSize) {
        const float fx = at.x - 0.5f - static_cast<float>(x);
        const float fy = at.y - 0.5f - static_cast<float>(y);
        const auto lit = [&](int dx, int dy) {
          return map.nearness[map.at(x + dx, y + dy)] <= at.z + kBias * texel ? 1.0f : 0.0f;
        };
        seen = glm::mix(glm::mix(lit(0, 0), lit(1, 0), fx), glm::mix(lit(0, 1), lit(1, 1), fx), fy);
      }
      sum[i] += lamp.power * cosine * seen * unit_;
    });
  }
  return sum;
}

}  // namespace planish::render
