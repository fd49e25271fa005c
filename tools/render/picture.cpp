#include "picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "dome_light.h"
#include "planish/core/parallel.h"
#include "planish/core/point_bounds.h"
#include "planish/job/page/colours.h"
#include "planish/job/page/rasterise.h"

namespace planish::render {
namespace {

constexpr int kScale = 4;  // samples along each side of a pixel
constexpr int kFloorCells = 480;
constexpr float kFloorReach = 3.2f;  // half the lit floor's side, in radii of the mesh
constexpr float kWireWidth = 3.2f;   // in samples
constexpr float kStripeCount = 9;    // black and white pairs over half a turn

// A square of the plane that the mesh stands on, and how much of the light reaches it.
struct Floor {
  float height = 0, reach = 1;
  glm::vec2 centre{0};
  std::vector<float> light;  // (kFloorCells + 1)^2, 1 where nothing is in the way

  glm::vec3 corner(int i, int j) const {
    const auto place = [&](int k) {
      return reach * (2.0f * static_cast<float>(k) / kFloorCells - 1);
    };
    return {centre.x + place(i), height, centre.y + place(j)};
  }

  float at(const glm::vec3& p) const {
    const glm::vec2 offset = (glm::vec2(p.x, p.z) - centre) / reach;
    const float away = glm::length(offset);
    if (away >= 1) return 1;
    const glm::vec2 cell = (offset * 0.5f + 0.5f) * static_cast<float>(kFloorCells);
    const int i = std::min(static_cast<int>(cell.x), kFloorCells - 1);
    const int j = std::min(static_cast<int>(cell.y), kFloorCells - 1);
    const float u = cell.x - static_cast<float>(i), v = cell.y - static_cast<float>(j);
    const auto value = [&](int a, int b) { return light[(j + b) * (kFloorCells + 1) + i + a]; };
    const float lit =
        glm::mix(glm::mix(value(0, 0), value(1, 0), u), glm::mix(value(0, 1), value(1, 1), u), v);
    return glm::mix(lit, 1.0f, glm::smoothstep(0.5f, 1.0f, away));
  }
};

Floor floor_under(const RenderMesh& mesh) {
  const auto [low, high] = point_bounds(mesh.positions);
  Floor floor;
  floor.height = low.y;
  floor.reach = kFloorReach * 0.5f * glm::distance(low, high);
  floor.centre = 0.5f * glm::vec2(low.x + high.x, low.z + high.z);
  return floor;
}

// One of the triangles at one of the samples.
struct Hit {
  std::array<std::uint32_t, 3> corners;
  glm::vec3 weights;  // perspective-correct

  template <class Value>
  Value mix(const std::vector<Value>& values) const {
    return weights.x * values[corners[0]] + weights.y * values[corners[1]] +
           weights.z * values[corners[2]];
  }
};

class Painter {
 public:
  Painter(const RenderMesh& mesh, const PictureOptions& options, const Camera& camera)
      : mesh_(mesh),
        options_(options),
        camera_(camera),
        light_(mesh, camera),
        buffer_(options.width * kScale, options.height * kScale),
        floor_(floor_under(mesh)),
        albedo_(linear(options.colour)) {
    for (const glm::vec3& p : mesh.positions) projected_.push_back(camera.project(p));
    constexpr int kBandRows = 64;
    const std::size_t bands = (buffer_.height + kBandRows - 1) / kBandRows;
    parallel_for(bands, 1, [&](std::size_t begin, std::size_t end) {
      rasterise(projected_, mesh.indices, static_cast<int>(begin) * kBandRows,
                std::min(buffer_.height, static_cast<int>(end) * kBandRows), buffer_);
    });
    if (options.overlay) draw_overlay(*options.overlay, camera, options.overlay_options, buffer_);
    bake_light();
    if (options.look == Look::Heat) curvature_ = curvature_of(mesh);
  }

  // Display-linear colour of a pixel.
  glm::vec3 pixel(int x, int y) const {
    glm::vec3 sum(0);
    for (int j = 0; j < kScale; ++j) {
      for (int i = 0; i < kScale; ++i) sum += sample(x * kScale + i, y * kScale + j);
    }
    return sum / static_cast<float>(kScale * kScale);
  }

 private:
  void bake_light();
  bool is_seen_from_behind(std::uint32_t triangle) const;
  bool any_seen_from_behind() const;
  Hit hit_at(std::uint32_t triangle, const glm::vec2& image) const;
  bool on_wire(std::uint32_t triangle, const glm::vec2& image) const;
  glm::vec3 sample(int x, int y) const;
  glm::vec3 background(const glm::vec2& image) const;
  glm::vec3 surface(const Hit& hit, bool is_behind, const glm::vec3& ray) const;

  const RenderMesh& mesh_;
  const PictureOptions& options_;
  const Camera& camera_;
  DomeLight light_;
  VisibilityBuffer buffer_;
  Floor floor_;
  glm::vec3 albedo_;
  std::vector<glm::vec3> projected_;
  std::vector<float> front_light_, back_light_, curvature_;
};

// By the triangle itself: normals turn away from the eye beside outlines already.
bool Painter::is_seen_from_behind(std::uint32_t triangle) const {
  const std::uint32_t* corners = mesh_.indices.data() + 3 * std::size_t{triangle};
  const glm::vec3 a = mesh_.positions[corners[0]];
  const glm::vec3 area =
      glm::cross(mesh_.positions[corners[1]] - a, mesh_.positions[corners[2]] - a);
  return glm::dot(area, a - camera_.eye) > 0;
}

bool Painter::any_seen_from_behind() const {
  return std::ranges::any_of(buffer_.what, [&](std::uint32_t what) {
    return what < kVertexSample && is_seen_from_behind(what);
  });
}

// One call for the front of the surface, its back where that is seen, and the floor: the lamps'
// shadow maps are most of the work.
void Painter::bake_light() {
  const std::size_t count = mesh_.positions.size();
  const std::size_t sides = any_seen_from_behind() ? 2 : 1;
  std::vector<LitPoint> points;
  for (std::size_t side = 0; side < sides; ++side) {
    for (std::size_t v = 0; v < count; ++v) {
      points.push_back({mesh_.positions[v], side == 0 ? mesh_.normals[v] : -mesh_.normals[v]});
    }
  }
  const glm::vec3 up(0, 1, 0);
  for (int j = 0; j <= kFloorCells; ++j) {
    for (int i = 0; i <= kFloorCells; ++i) points.push_back({floor_.corner(i, j), up});
  }
  const std::vector<float> lit = light_.irradiance(points);
  const auto part = [&](std::size_t begin, std::size_t end) {
    return std::vector<float>(lit.begin() + static_cast<std::ptrdiff_t>(begin),
                              lit.begin() + static_cast<std::ptrdiff_t>(end));
  };
  front_light_ = part(0, count);
  back_light_ = part((sides - 1) * count, sides * count);
  floor_.light = part(sides * count, lit.size());
  const float free = light_.free_irradiance(up);
  for (float& value : floor_.light) value /= free;
}

Hit Painter::hit_at(std::uint32_t triangle, const glm::vec2& image) const {
  Hit hit{};
  for (int k = 0; k < 3; ++k) hit.corners[k] = mesh_.indices[3 * triangle + k];
  const glm::vec3 &a = projected_[hit.corners[0]], &b = projected_[hit.corners[1]],
                  &c = projected_[hit.corners[2]];
  const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  const float v = ((image.x - a.x) * (c.y - a.y) - (image.y - a.y) * (c.x - a.x)) / area;
  const float w = ((b.x - a.x) * (image.y - a.y) - (b.y - a.y) * (image.x - a.x)) / area;
  const glm::vec3 perspective = glm::vec3(1 - v - w, v, w) * glm::vec3(a.z, b.z, c.z);
  hit.weights = perspective / (perspective.x + perspective.y + perspective.z);
  return hit;
}

// The two triangles of a quad follow each other and share its diagonal, which is not drawn.
bool Painter::on_wire(std::uint32_t triangle, const glm::vec2& image) const {
  const std::uint32_t* corners = mesh_.indices.data() + 3 * triangle;
  const std::size_t twin = 3 * static_cast<std::size_t>(triangle ^ 1u);
  const auto in_twin = [&](std::uint32_t corner) {
    return twin + 3 <= mesh_.indices.size() &&
           std::find(&mesh_.indices[twin], &mesh_.indices[twin] + 3, corner) !=
               &mesh_.indices[twin] + 3;
  };
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t from = corners[k], to = corners[(k + 1) % 3];
    if (in_twin(from) && in_twin(to)) continue;
    const glm::vec2 a(projected_[from]), d = glm::vec2(projected_[to]) - a, p = image - a;
    const float along = glm::clamp(glm::dot(p, d) / glm::dot(d, d), 0.0f, 1.0f);
    if (glm::distance(p, along * d) < kWireWidth / 2) return true;
  }
  return false;
}

glm::vec3 Painter::background(const glm::vec2& image) const {
  const float down = image.y / static_cast<float>(buffer_.height);
  const glm::vec3 paper =
      glm::mix(glm::vec3(0.90f, 0.905f, 0.915f), glm::vec3(0.80f, 0.805f, 0.815f),
               glm::smoothstep(0.0f, 1.0f, down));
  const glm::vec3 ray = camera_.ray(image);
  if (ray.y >= 0) return paper;
  const float distance = (floor_.height - camera_.eye.y) / ray.y;
  if (distance <= 0) return paper;
  return paper * glm::mix(1.0f, floor_.at(camera_.eye + distance * ray), 0.85f);
}

glm::vec3 Painter::surface(const Hit& hit, bool is_behind, const glm::vec3& ray) const {
  glm::vec3 normal = glm::normalize(hit.mix(mesh_.normals));
  if (is_behind) normal = -normal;
  const float light = hit.mix(is_behind ? back_light_ : front_light_);
  const glm::vec3 mirrored = glm::reflect(ray, normal);
  if (options_.look == Look::Stripes) {
    // Bands of light all round the model, seen in a mirror.
    const glm::vec3 axis = glm::normalize(camera_.up + 0.35f * camera_.right);
    const float turn = std::acos(glm::clamp(glm::dot(mirrored, axis), -1.0f, 1.0f));
    const bool bright = std::fmod(turn * kStripeCount / 3.14159265f, 1.0f) < 0.5f;
    return glm::vec3(bright ? 0.80f : 0.045f) * (0.55f + 0.45f * light);
  }
  const glm::vec3 base = options_.look == Look::Heat ? heat_colour(hit.mix(curvature_))
                         : options_.look == Look::Values
                             ? signed_colour(hit.mix(mesh_.values) / options_.scale)
                             : albedo_;
  // A satin coat: a soft highlight of the main light, and the room at grazing angles.
  const glm::vec3 half = glm::normalize(light_.key() - ray);
  const float facing = glm::clamp(-glm::dot(normal, ray), 0.0f, 1.0f);
  const float shine = 0.16f * std::pow(glm::max(glm::dot(normal, half), 0.0f), 42.0f);
  const float rim = 0.16f * std::pow(1 - facing, 4.0f);
  return (base + glm::vec3(shine + rim)) * light * 1.02f;
}

glm::vec3 Painter::sample(int x, int y) const {
  const glm::vec2 image(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
  const std::uint32_t what = buffer_.what[buffer_.at(x, y)];
  if (what == VisibilityBuffer::kNothing) return background(image);
  if (what == kEdgeSample) return linear(glm::vec3(0.13f, 0.20f, 0.30f));
  if (what == kVertexSample) return linear(glm::vec3(0.80f, 0.22f, 0.10f));
  glm::vec3 colour =
      soft_shoulder(surface(hit_at(what, image), is_seen_from_behind(what), camera_.ray(image)));
  if (options_.wire && on_wire(what, image)) colour *= 0.35f;
  return colour;
}

}  // namespace

std::vector<std::uint8_t> draw_picture(const RenderMesh& mesh, const PictureOptions& options) {
  std::vector<glm::vec3> framed = mesh.positions;
  if (options.overlay) {
    for (const glm::dvec3& p : options.overlay->positions) framed.emplace_back(p);
  }
  const Camera camera =
      frame(framed, options.width * kScale, options.height * kScale, options.view);
  const Painter painter(mesh, options, camera);
  std::vector<std::uint8_t> pixels(std::size_t{3} * options.width * options.height);
  parallel_each(static_cast<std::size_t>(options.height), 4, [&](std::size_t y) {
    for (int x = 0; x < options.width; ++x) {
      const glm::vec3 colour = displayed(painter.pixel(x, static_cast<int>(y)));
      for (int k = 0; k < 3; ++k) {
        pixels[3 * (y * options.width + x) + k] =
            static_cast<std::uint8_t>(std::lround(255 * colour[k]));
      }
    }
  });
  return pixels;
}

}  // namespace planish::render
