#include "planish/job/page/page_still.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/core/parallel.h"
#include "planish/core/point_bounds.h"
#include "planish/files/image/png.h"
#include "planish/job/page/camera.h"
#include "planish/job/page/colours.h"
#include "planish/job/page/page.h"
#include "planish/job/page/rasterise.h"

namespace planish {

namespace {

using glm::vec3;

constexpr int kScale = 2;  // samples along each side of a pixel

// With y up, around the middle of the box: single precision is enough there.
class Upright {
 public:
  Upright(const SurfaceMesh& surface, UpAxis up) : up_(up) {
    const auto [low, high] = point_bounds(surface.positions);
    middle_ = 0.5 * low + 0.5 * high;
  }
  [[nodiscard]] vec3 place(const glm::dvec3& p) const { return turned(vec3(p - middle_)); }
  [[nodiscard]] vec3 turned(const vec3& v) const {
    return up_ == UpAxis::Z ? vec3(v.x, v.z, -v.y) : v;
  }

 private:
  UpAxis up_;
  glm::dvec3 middle_;
};

std::vector<std::uint32_t> indices_of(const SurfaceMesh& surface) {
  std::vector<std::uint32_t> indices;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    for (std::size_t k = 2; k < face.size(); ++k)
      for (const std::int32_t v : {face[0], face[k - 1], face[k]})
        indices.push_back(static_cast<std::uint32_t>(v));
  }
  return indices;
}

// Clay in daylight; what is seen from behind is bluish.
vec3 colour_of(vec3 normal, const vec3& towards_eye, const render::Camera& camera) {
  const bool is_behind = glm::dot(normal, towards_eye) < -0.2f;
  if (is_behind) normal = -normal;
  const vec3 clay =
      render::linear(is_behind ? vec3(0.45f, 0.55f, 0.75f) : vec3(0.81f, 0.82f, 0.84f));
  const vec3 key =
      glm::normalize(-0.5f * camera.right + 0.7f * vec3(0, 1, 0) - 0.6f * camera.forward);
  const float sky = 0.5f + 0.5f * normal.y;
  return clay * (0.18f + 0.32f * sky + 0.75f * std::max(glm::dot(normal, key), 0.0f));
}

struct Picture {
  const SurfaceMesh& surface;
  const Upright& upright;
  const std::vector<std::uint32_t>& indices;
  const std::vector<vec3>& projected;
  const render::Camera& camera;

  [[nodiscard]] vec3 sample(std::uint32_t triangle, float x, float y) const {
    const std::uint32_t* corner = &indices[3 * static_cast<std::size_t>(triangle)];
    const vec3 &a = projected[corner[0]], &b = projected[corner[1]], &c = projected[corner[2]];
    const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    const float v = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / area;
    const float w = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / area;
    const vec3 sum = (1 - v - w) * surface.normals[corner[0]] + v * surface.normals[corner[1]] +
                     w * surface.normals[corner[2]];
    const float length = glm::length(sum);
    const vec3 normal = length > 0 ? upright.turned(sum / length) : vec3(0);
    return colour_of(normal, -camera.ray({x, y}), camera);
  }
};

}  // namespace

std::vector<std::byte> still_picture(const SurfaceMesh& surface, UpAxis up) {
  const Upright upright(surface, up);
  std::vector<vec3> points(surface.positions.size());
  parallel_each(points.size(),
                [&](std::size_t v) { points[v] = upright.place(surface.positions[v]); });
  render::VisibilityBuffer buffer(kScale * kStillWidth, kScale * kStillHeight);
  const render::Camera camera = render::frame(points, buffer.width, buffer.height, {});
  parallel_each(points.size(), [&](std::size_t v) { points[v] = camera.project(points[v]); });
  const std::vector<std::uint32_t> indices = indices_of(surface);
  constexpr std::size_t kBands = 8;
  constexpr int kBandRows = kScale * kStillHeight / kBands;
  parallel_for(kBands, 1, [&](std::size_t begin, std::size_t end) {
    render::rasterise(points, indices, static_cast<int>(begin) * kBandRows,
                      static_cast<int>(end) * kBandRows, buffer);
  });

  const Picture picture{surface, upright, indices, points, camera};
  std::vector<std::uint8_t> pixels(std::size_t{4} * kStillWidth * kStillHeight);
  parallel_for(kStillHeight, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y) {
      for (int x = 0; x < kStillWidth; ++x) {
        vec3 sum(0);
        int hits = 0;
        for (int s = 0; s < kScale * kScale; ++s) {
          const int i = kScale * x + s % kScale, j = kScale * static_cast<int>(y) + s / kScale;
          const std::uint32_t triangle = buffer.what[buffer.at(i, j)];
          if (triangle == render::VisibilityBuffer::kNothing) continue;
          sum +=
              picture.sample(triangle, static_cast<float>(i) + 0.5f, static_cast<float>(j) + 0.5f);
          ++hits;
        }
        if (hits == 0) continue;
        const vec3 shown = render::displayed(render::soft_shoulder(sum / static_cast<float>(hits)));
        std::uint8_t* pixel = &pixels[4 * (y * kStillWidth + static_cast<std::size_t>(x))];
        for (int k = 0; k < 3; ++k)
          pixel[k] = static_cast<std::uint8_t>(std::lround(255 * shown[k]));
        pixel[3] = static_cast<std::uint8_t>(255 * hits / (kScale * kScale));
      }
    }
  });
  return png_of(kStillWidth, 4, pixels);
}

}  // namespace planish
