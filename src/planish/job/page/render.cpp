#include "planish/job/page/render.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>

#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/files/images.h"
#include "planish/job/page/page.h"

namespace planish::render {
namespace {

constexpr float kFieldOfViewDegrees = 28;  // vertical; long enough to leave shapes undistorted

}  // namespace

glm::vec3 Camera::project(const glm::vec3& point) const {
  const glm::vec3 d = point - eye;
  const float inverse = 1.0f / glm::dot(d, forward);
  return {principal.x + focal * glm::dot(d, right) * inverse,
          principal.y - focal * glm::dot(d, up) * inverse, inverse};
}

glm::vec3 Camera::ray(const glm::vec2& image) const {
  const glm::vec2 d = (image - principal) / focal;
  return glm::normalize(forward + d.x * right - d.y * up);
}

Camera frame(std::span<const glm::vec3> points, int width, int height, const ViewOptions& options) {
  const double azimuth = glm::radians(options.azimuth_degrees);
  const double elevation = glm::radians(options.elevation_degrees);
  Camera camera;
  camera.forward =
      -glm::vec3(portable::sin(azimuth) * portable::cos(elevation), portable::sin(elevation),
                 portable::cos(azimuth) * portable::cos(elevation));
  camera.right = glm::vec3(portable::cos(azimuth), 0, -portable::sin(azimuth));
  camera.up = glm::cross(camera.right, camera.forward);
  camera.focal = static_cast<float>(0.5 * height /
                                    portable::tan(glm::radians(double{kFieldOfViewDegrees} / 2)));
  camera.principal = {0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height)};

  // The planes of the image's four sides pass through the eye: along each of their normals the
  // farthest point decides, and two opposite planes meet at the eye.
  const glm::vec2 half = (1 - 2 * options.margin) * camera.principal / camera.focal;
  constexpr float kLowest = std::numeric_limits<float>::lowest();
  glm::vec2 plus(kLowest), minus(kLowest);
  for (const glm::vec3& p : points) {
    const glm::vec2 across(glm::dot(p, camera.right), glm::dot(p, camera.up));
    const float along = glm::dot(p, camera.forward);
    plus = glm::max(plus, across - half * along);
    minus = glm::max(minus, -across - half * along);
  }
  const glm::vec2 centre = 0.5f * (plus - minus);
  const glm::vec2 along = -0.5f * (plus + minus) / half;
  camera.eye =
      centre.x * camera.right + centre.y * camera.up + std::min(along.x, along.y) * camera.forward;
  const glm::vec2 target = options.middle * 2.0f * camera.principal;
  camera.principal += options.zoom * (camera.principal - target);
  camera.focal *= options.zoom;
  return camera;
}

namespace {

// Based on: Pineda, "A parallel algorithm for polygon rasterization", 1988.

struct Span {
  int first, last;
};

// Where a row crosses a triangle, and a sample more on both sides: of slivers little of their box.
Span span_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double y, Span box) {
  const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  double least = box.first, most = box.last;
  const auto cut = [&](const glm::dvec3& from, const glm::dvec3& to) {
    // Left of the edge, where the triangle's inside is: slope * x >= bound.
    const double slope = -(to.y - from.y) * area;
    const double bound = slope * from.x - (to.x - from.x) * area * (y - from.y);
    if (slope == 0) return;
    const double x = bound / slope - 0.5;
    if (slope > 0) {
      least = std::max(least, std::floor(x) - 1);
    } else {
      most = std::min(most, std::ceil(x) + 1);
    }
  };
  cut(a, b);
  cut(b, c);
  cut(c, a);
  if (!(least <= most)) return {0, -1};
  return {static_cast<int>(least), static_cast<int>(most)};
}

}  // namespace

void rasterise(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> indices,
               int row_begin, int row_end, VisibilityBuffer& buffer) {
  for (std::size_t t = 0; t + 2 < indices.size(); t += 3) {
    const glm::vec3 &a = vertices[indices[t]], &b = vertices[indices[t + 1]],
                    &c = vertices[indices[t + 2]];
    const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) continue;
    // Samples lie at the middle of their square.
    const int x0 = std::max(0, static_cast<int>(std::ceil(std::min({a.x, b.x, c.x}) - 0.5f)));
    const int x1 =
        std::min(buffer.width - 1, static_cast<int>(std::floor(std::max({a.x, b.x, c.x}) - 0.5f)));
    const int y0 =
        std::max(row_begin, static_cast<int>(std::ceil(std::min({a.y, b.y, c.y}) - 0.5f)));
    const int y1 =
        std::min(row_end - 1, static_cast<int>(std::floor(std::max({a.y, b.y, c.y}) - 0.5f)));
    const float scale = 1 / area;
    for (int y = y0; y <= y1; ++y) {
      const float py = static_cast<float>(y) + 0.5f;
      const auto [first, last] = span_of(a, b, c, py, {x0, x1});
      for (int x = first; x <= last; ++x) {
        const float px = static_cast<float>(x) + 0.5f;
        const float v = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) * scale;
        const float w = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) * scale;
        if (v < 0 || w < 0 || v + w > 1) continue;
        const float nearness = a.z + v * (b.z - a.z) + w * (c.z - a.z);
        const std::size_t sample = buffer.at(x, y);
        if (nearness <= buffer.nearness[sample]) continue;
        buffer.nearness[sample] = nearness;
        buffer.what[sample] = static_cast<std::uint32_t>(t / 3);
      }
    }
  }
}

}  // namespace planish::render

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

std::vector<std::byte> still_picture(const SurfaceMesh& surface, UpAxis up, int width, int height) {
  const Upright upright(surface, up);
  std::vector<vec3> points(surface.positions.size());
  parallel_each(points.size(),
                [&](std::size_t v) { points[v] = upright.place(surface.positions[v]); });
  render::VisibilityBuffer buffer(kScale * width, kScale * height);
  const render::Camera camera = render::frame(points, buffer.width, buffer.height, {});
  parallel_each(points.size(), [&](std::size_t v) { points[v] = camera.project(points[v]); });
  const std::vector<std::uint32_t> indices = indices_of(surface);
  constexpr std::size_t kBands = 8;
  const int band_rows = (buffer.height + static_cast<int>(kBands) - 1) / static_cast<int>(kBands);
  parallel_for(kBands, 1, [&](std::size_t begin, std::size_t end) {
    render::rasterise(points, indices, static_cast<int>(begin) * band_rows,
                      std::min(static_cast<int>(end) * band_rows, buffer.height), buffer);
  });

  const Picture picture{surface, upright, indices, points, camera};
  std::vector<std::uint8_t> pixels(std::size_t{4} * static_cast<std::size_t>(width) *
                                   static_cast<std::size_t>(height));
  parallel_for(static_cast<std::size_t>(height), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y) {
      for (int x = 0; x < width; ++x) {
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
        std::uint8_t* pixel =
            &pixels[4 * (y * static_cast<std::size_t>(width) + static_cast<std::size_t>(x))];
        for (int k = 0; k < 3; ++k)
          pixel[k] = static_cast<std::uint8_t>(std::lround(255 * shown[k]));
        pixel[3] = static_cast<std::uint8_t>(255 * hits / (kScale * kScale));
      }
    }
  });
  return png_of(width, 4, pixels);
}

}  // namespace planish
