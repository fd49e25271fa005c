#include "picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <string_view>
#include <utility>

#include "planish/core/json.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/files/read_file.h"
#include "planish/job/page/render.h"

namespace planish::render {
namespace {

// Turns normals as the surface turns: by cofactors, which need no inverse.
glm::dmat3 normals_transform(const glm::dmat3& m) {
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                             glm::cross(m[0], m[1]));
  return glm::determinant(m) < 0 ? -cofactors : cofactors;
}

class SceneDrawing {
 public:
  SceneDrawing(const JsonPlace& root, GltfSource& source, std::string_view file,
               const std::string& attribute)
      : root_(root), source_(source), budget_({}, file), attribute_(attribute) {}

  RenderMesh read() {
    const std::vector<GltfInstance> instances = gltf_scene(root_, source_).instances;
    if (!instances.empty()) mesh_.origin = instances.front().to_world[3];
    for (const GltfInstance& instance : instances) {
      const JsonPlace primitives = root_["meshes"][instance.mesh]["primitives"];
      for (std::int64_t i = 0; i < primitives.array_size(); ++i)
        add_primitive(primitives[i], instance.to_world);
    }
    if (mesh_.indices.empty()) root_.fail("its default scene places no triangles");
    return std::move(mesh_);
  }

 private:
  void add_primitive(const JsonPlace& primitive, const glm::dmat4& to_world);

  const JsonPlace& root_;
  GltfSource& source_;
  GltfBudget budget_;
  const std::string& attribute_;
  RenderMesh mesh_;
};

// Appends triangles.
void SceneDrawing::add_primitive(const JsonPlace& primitive, const glm::dmat4& to_world) {
  const auto accessor = [&](const JsonPlace& place, GltfAccessor::Use use) {
    return GltfAccessor(root_, place.integer(), use, source_);
  };
  const JsonPlace attributes = primitive["attributes"];
  const GltfAccessor positions = accessor(attributes["POSITION"], GltfAccessor::Use::Positions);
  // Vectors of three as well.
  const GltfAccessor normals = accessor(attributes["NORMAL"], GltfAccessor::Use::Positions);
  const GltfAccessor indices = accessor(primitive["indices"], GltfAccessor::Use::Indices);
  if (normals.count() != positions.count())
    attributes["NORMAL"].fail("{} normals for {} vertices", normals.count(), positions.count());
  budget_.add_triangles(primitive, positions.count(), indices.count());
  const glm::dmat3 linear(to_world), turned = normals_transform(linear);
  const glm::dvec3 shift = glm::dvec3(to_world[3]) - mesh_.origin;
  const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
  for (std::int64_t i = 0; i < positions.count(); ++i) {
    mesh_.positions.emplace_back(linear * positions.position(i) + shift);
    mesh_.normals.push_back(glm::normalize(glm::vec3(turned * normals.position(i))));
  }
  if (!attribute_.empty()) {
    const GltfAccessor values = accessor(attributes[attribute_], GltfAccessor::Use::Numbers);
    if (values.count() != positions.count())
      attributes[attribute_].fail("{} numbers for {} vertices", values.count(), positions.count());
    for (std::int64_t i = 0; i < values.count(); ++i)
      mesh_.values.push_back(static_cast<float>(values.value(i)));
  }
  for (std::int64_t i = 0; i < indices.count(); ++i) {
    if (indices.index(i) >= positions.count())
      primitive["indices"].fail("entry {} names no vertex", i);
    mesh_.indices.push_back(first + indices.index(i));
  }
}

}  // namespace

RenderMesh read_glb(const std::filesystem::path& path, const std::string& attribute) {
  const RawVector<std::byte> bytes = read_file(path);
  const std::string name = path.string();
  const GlbParts parts = split_glb(bytes, name);
  const nlohmann::json document = parse_json(parts.json, name);
  const JsonPlace root(document, name, "");
  GltfSource source(root, parts.chunk, FileBytes{});
  return SceneDrawing(root, source, name, attribute).read();
}

float usual_magnitude(const std::vector<float>& values) {
  std::vector<float> sizes;
  for (const float value : values)
    if (std::isfinite(value)) sizes.push_back(std::abs(value));
  if (sizes.empty()) return 1;
  const auto place = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 19 / 20);
  std::nth_element(sizes.begin(), place, sizes.end());
  return *place > 0 ? *place : 1;
}

std::vector<float> curvature_of(const RenderMesh& mesh) {
  const auto [low, high] = point_bounds(mesh.positions);
  const float diagonal = glm::distance(low, high);
  std::vector<float> sum(mesh.positions.size()), count(mesh.positions.size());
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::uint32_t a = mesh.indices[i];
    const std::uint32_t b = mesh.indices[i % 3 == 2 ? i - 2 : i + 1];
    const float length = glm::distance(mesh.positions[a], mesh.positions[b]);
    if (length <= 0) continue;
    const float turn = glm::distance(mesh.normals[a], mesh.normals[b]) / length * diagonal;
    for (const std::uint32_t v : {a, b}) {
      sum[v] += turn;
      count[v] += 1;
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] /= std::max(count[v], 1.0f);
  return sum;
}

namespace {

// Each lamp is far away: the mesh is drawn once into a depth map for each, and points behind what
// the lamp sees are in its shadow.

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
