#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "files/gltf/glb_bytes.h"
#include "planish/core/json.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// An asset with everything that is to pass: a skinned tube of two materials, of which one has
/// textures of colours and normals, two
/// sets of texture coordinates and a morph target, whose first triangles lie beside points that
/// only morph apart; a ball with colours and numbers of its own that two nodes place; the ball
/// again, instanced, beside a line; a lamp, a camera, an animation, and an extension that nobody
/// knows.
class AssetSample : public GlbParts {
 public:
  AssetSample() {
    add_tube();
    add_ball();
    add_rest();
  }

  /// A .gltf of the same, whose buffer is `buffer` and whose image `image`.
  [[nodiscard]] std::string gltf(const std::string& buffer, const std::string& image) {
    nlohmann::json beside = json;
    beside["buffers"] = {{{"byteLength", bytes.size()}, {"uri", buffer}}};
    beside["images"] = {{{"uri", image}}};
    return beside.dump();
  }
  /// A PNG of one pixel.
  [[nodiscard]] static std::string image() {
    constexpr unsigned char kBytes[] = {
        0x89, 0x50, 0x4E, 0x47, 0x0D, 0x0A, 0x1A, 0x0A, 0x00, 0x00, 0x00, 0x0D, 0x49, 0x48,
        0x44, 0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00,
        0x00, 0x90, 0x77, 0x53, 0xDE, 0x00, 0x00, 0x00, 0x0C, 0x49, 0x44, 0x41, 0x54, 0x78,
        0x9C, 0x63, 0xF8, 0xDF, 0xC0, 0x00, 0x00, 0x04, 0x01, 0x01, 0x80, 0xC5, 0x2A, 0x18,
        0x5D, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4E, 0x44, 0xAE, 0x42, 0x60, 0x82};
    return {std::begin(kBytes), std::end(kBytes)};
  }

  /// Shifts the tube's vertices in the buffer: by(vertex, axis).
  template <class By>
  void move_tube(const By& by) {
    for (std::size_t v = 0; v < tube.size(); ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        const float value = static_cast<float>(tube[v][k]) + static_cast<float>(by(v, k));
        std::memcpy(bytes.data() + position_offset_ + 12 * v + 4 * k, &value, sizeof(value));
      }
    }
  }
  /// Both halves of the tube show the texture, one of them mirrored: u becomes |1 - 2 u|.
  void mirror_texture() {
    for (std::size_t v = 0; v < tube.size(); ++v) {
      float u = 0;
      std::memcpy(&u, bytes.data() + uv_offset_ + 8 * v, sizeof(u));
      u = std::abs(1 - 2 * u);
      std::memcpy(bytes.data() + uv_offset_ + 8 * v, &u, sizeof(u));
    }
  }
  /// A vertex of the tube as it stands in the buffer.
  [[nodiscard]] std::array<float, 3> stored(std::size_t vertex) const {
    std::array<float, 3> point;
    std::memcpy(point.data(), bytes.data() + position_offset_ + 12 * vertex, sizeof(point));
    return point;
  }

  static constexpr int kAround = 12, kRings = 16;

  std::vector<std::array<double, 3>> tube, moves;      // of the tube's vertices
  std::vector<std::array<double, 2>> weights;          // of its two joints
  std::vector<std::array<std::int32_t, 3>> triangles;  // of it

 private:
  template <std::size_t N>
  std::size_t add_floats(const std::vector<std::array<double, N>>& rows, bool has_bounds = false) {
    constexpr std::array kTypes{"SCALAR", "VEC2", "VEC3", "VEC4"};
    std::string view;
    std::array<float, N> least, most;
    least.fill(INFINITY), most.fill(-INFINITY);
    for (const auto& row : rows) {
      for (std::size_t k = 0; k < N; ++k) {
        const auto value = static_cast<float>(row[k]);
        append<float>(view, value);
        least[k] = std::min(least[k], value), most[k] = std::max(most[k], value);
      }
    }
    const std::size_t number = add_accessor(view, 5126, rows.size(), kTypes[N - 1]);
    if (has_bounds)
      json["accessors"][number]["min"] = least, json["accessors"][number]["max"] = most;
    return number;
  }
  std::size_t add_indices(const std::vector<std::array<std::int32_t, 3>>& faces, std::size_t first,
                          std::size_t end) {
    std::string view;
    for (std::size_t i = first; i < end; ++i)
      for (const std::int32_t v : faces[i])
        append<std::uint16_t>(view, static_cast<std::uint16_t>(v));
    return add_accessor(view, 5123, 3 * (end - first), "SCALAR");
  }

  void add_tube() {
    std::vector<std::array<double, 2>> uvs, further;
    std::vector<std::array<double, 4>> of_joints;
    std::string joints;
    for (int j = 0; j <= kRings; ++j) {
      for (int i = 0; i <= kAround; ++i) {
        const double angle = 2 * std::numbers::pi * (i % kAround) / kAround, y = 4.0 * j / kRings;
        tube.push_back({0.5 * std::cos(angle), y, 0.5 * std::sin(angle)});
        uvs.push_back({static_cast<double>(i) / kAround, static_cast<double>(j) / kRings});
        further.push_back({0.5 * uvs.back()[0], 0.25 + 0.5 * uvs.back()[1]});
        const double t = std::clamp((y - 1) / 2, 0.0, 1.0), second = t * t * (3 - 2 * t);
        weights.push_back({1 - second, second});
        of_joints.push_back({1 - second, second, 0, 0});
        const double fat = y > 1 && y < 3 ? 0.4 : 0.0;
        moves.push_back({fat * std::cos(angle), 0, fat * std::sin(angle)});
        for (const int joint : {0, 1, 0, 0}) joints += static_cast<char>(joint);
      }
    }
    for (int j = 0; j < kRings; ++j) {
      for (int i = 0; i < kAround; ++i) {
        const std::int32_t a = j * (kAround + 1) + i, c = a + kAround + 1;
        triangles.push_back({a, c, a + 1});
        triangles.push_back({a + 1, c, c + 1});
      }
    }
    const std::size_t positions = add_floats(tube, true), texture = add_floats(uvs);
    uv_offset_ = json["bufferViews"][texture]["byteOffset"].get<std::size_t>();
    const nlohmann::json attributes = {
        {"POSITION", positions},
        {"TEXCOORD_0", texture},
        {"TEXCOORD_1", add_floats(further)},
        {"JOINTS_0", add_accessor(joints, 5121, tube.size(), "VEC4")},
        {"WEIGHTS_0", add_floats(of_joints)}};
    const nlohmann::json targets = {{{"POSITION", add_floats(moves, true)}}};
    const std::size_t half = triangles.size() / 2;
    nlohmann::json primitives;
    for (int part = 0; part < 2; ++part)
      primitives.push_back(
          {{"attributes", attributes},
           {"indices", add_indices(triangles, part == 0 ? 0 : half, part == 0 ? half : 2 * half)},
           {"material", part},
           {"targets", targets}});
    json["meshes"].push_back({{"name", "tube"},
                              {"weights", {0.0}},
                              {"extras", {{"targetNames", {"fat"}}}},
                              {"primitives", primitives}});
  }

  void add_ball() {
    constexpr int kCircles = 8, kSides = 12;
    std::vector<std::array<double, 3>> points{{0, 1, 0}};
    std::vector<std::array<std::int32_t, 3>> faces;
    for (int k = 1; k < kCircles; ++k) {
      for (int i = 0; i < kSides; ++i) {
        const double a = std::numbers::pi * k / kCircles, b = 2 * std::numbers::pi * i / kSides;
        points.push_back({std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b)});
      }
    }
    points.push_back({0, -1, 0});
    const auto last = static_cast<std::int32_t>(points.size()) - 1;
    for (std::int32_t i = 0; i < kSides; ++i) {
      const std::int32_t next = (i + 1) % kSides, low = 1 + (kCircles - 2) * kSides;
      faces.push_back({0, 1 + next, 1 + i});
      faces.push_back({last, low + i, low + next});
      for (std::int32_t k = 0; k < kCircles - 2; ++k) {
        const std::int32_t a = 1 + k * kSides + i, b = 1 + k * kSides + next;
        faces.push_back({a, b, a + kSides});
        faces.push_back({b, b + kSides, a + kSides});
      }
    }
    std::vector<std::array<double, 4>> colors;
    std::vector<std::array<double, 1>> heat;
    for (const auto& point : points) {
      colors.push_back({0.5 + 0.5 * point[0], 0.5, 0.5 - 0.5 * point[1], 1});
      heat.push_back({10 * point[1]});
    }
    const std::size_t positions = add_floats(points, true);
    const std::size_t indices = add_indices(faces, 0, faces.size());
    json["meshes"].push_back({{"name", "ball"},
                              {"primitives",
                               {{{"attributes",
                                  {{"POSITION", positions},
                                   {"COLOR_0", add_floats(colors)},
                                   {"_HEAT", add_floats(heat)}}},
                                 {"indices", indices},
                                 {"material", 2}}}}});
    const std::size_t line = add_floats<3>({{0, 0, 0}, {1, 1, 1}}, true);
    json["meshes"].push_back(
        {{"name", "many"},
         {"primitives",
          {{{"attributes", {{"POSITION", positions}}},
            {"indices", indices},
            {"material", 1},
            {"extras", {{"id", 4}}}},
           {{"attributes", {{"POSITION", line}}}, {"mode", 1}, {"material", 1}}}}});
  }

  void add_rest() {
    std::string matrices;
    for (const double height : {0.0, -2.0})
      for (const double value :
           {1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., height, 0., 1.})
        append<float>(matrices, static_cast<float>(value));
    const std::size_t bind = add_accessor(matrices, 5126, 2, "MAT4");
    const std::size_t times = add_floats<1>({{0}, {1}, {2}}, true);
    const std::size_t turns = add_floats<4>({{0, 0, 0, 1}, {0, 0, 0.6, 0.8}, {0, 0, 0, 1}});
    const std::size_t shares = add_floats<1>({{0}, {1}, {0}});
    const std::size_t places = add_floats<3>({{0, 0, 0}, {3, 0, 0}, {6, 0, 0}});
    const std::size_t view = add_view(image());
    json.update(nlohmann::json::parse(R"({
      "asset": {"version": "2.0", "generator": "hand", "copyright": "me", "extras": {"pipeline": 7}},
      "extensionsUsed": ["EXT_mesh_gpu_instancing", "KHR_lights_punctual", "KHR_materials_clearcoat",
                         "VENDOR_secret"],
      "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 5.5}]},
                     "VENDOR_secret": {"of": [1, 2.5, "x"]}},
      "scene": 0, "scenes": [{"name": "main", "nodes": [0, 3, 4, 5, 6, 7, 8]}],
      "nodes": [{"name": "body", "mesh": 0, "skin": 0}, {"name": "low", "children": [2]},
                {"name": "high", "translation": [0, 2, 0]}, {"name": "armature", "children": [1]},
                {"name": "ball", "mesh": 1, "translation": [3, 1, 0], "extras": {"tag": "x"}},
                {"name": "half", "mesh": 1, "translation": [-3, 1, 0], "scale": [0.5, 0.5, 0.5]},
                {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}},
                {"name": "many", "mesh": 2, "extensions": {"EXT_mesh_gpu_instancing": {}}},
                {"name": "eye", "camera": 0, "translation": [0, 2, 9]}],
      "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
      "materials": [{"name": "check", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
                     "normalTexture": {"index": 0},
                     "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5}}},
                    {"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.1, 0.1, 1]}},
                    {"name": "plain", "doubleSided": true}],
      "textures": [{"source": 0, "sampler": 0}], "samplers": [{"magFilter": 9728}]})"));
    json["nodes"][7]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = places;
    json["images"] = {{{"bufferView", view}, {"mimeType", "image/png"}, {"name", "checker"}}};
    json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", bind}}};
    json["animations"] = {
        {{"name", "wave"},
         {"samplers",
          {{{"input", times}, {"output", turns}}, {{"input", times}, {"output", shares}}}},
         {"channels",
          {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}},
           {{"sampler", 1}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
  }

  std::size_t position_offset_ = 0, uv_offset_ = 0;
};

/// What rides on a mesh of a large asset.
struct Riders {
  int joints = 0, targets = 0;
};

/// A GLB of triangulated meshes, each in a node of its own. Of joints two move each vertex, as they
/// follow one another along the vertices; targets move all vertices.
inline std::string large_asset(const std::vector<PolygonMesh>& meshes,
                               const std::vector<Riders>& riders = {}) {
  GlbParts parts;
  nlohmann::json& json = parts.json;
  json["scene"] = 0;
  nlohmann::json roots;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const PolygonMesh& mesh = meshes[m];
    const Riders of = m < riders.size() ? riders[m] : Riders{};
    const std::size_t count = mesh.positions.size();
    std::string points, corners, joints, weights, moves;
    for (std::size_t v = 0; v < count; ++v) {
      for (int axis = 0; axis < 3; ++axis) {
        append<float>(points, static_cast<float>(mesh.positions[v][axis]));
        append<float>(moves, axis == 1 ? 0.1F : 0.0F);
      }
      const int first = static_cast<int>(static_cast<std::size_t>(of.joints) * v / count);
      for (const int joint : {first, std::min(first + 1, std::max(of.joints - 1, 0)), 0, 0})
        append<std::uint16_t>(joints, static_cast<std::uint16_t>(joint));
      for (const float weight : {0.75F, 0.25F, 0.0F, 0.0F}) append<float>(weights, weight);
    }
    std::size_t corner_count = 0;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const auto face = mesh.face(f);
      for (std::size_t k = 2; k < face.size(); ++k) {
        for (const std::int32_t v : {face[0], face[k - 1], face[k]})
          append<std::uint32_t>(corners, static_cast<std::uint32_t>(v));
        corner_count += 3;
      }
    }
    nlohmann::json primitive = {
        {"attributes", {{"POSITION", parts.add_accessor(points, 5126, count, "VEC3")}}},
        {"indices", parts.add_accessor(corners, 5125, corner_count, "SCALAR")}};
    nlohmann::json node = {{"mesh", m}};
    if (of.joints > 0) {
      primitive["attributes"]["JOINTS_0"] = parts.add_accessor(joints, 5123, count, "VEC4");
      primitive["attributes"]["WEIGHTS_0"] = parts.add_accessor(weights, 5126, count, "VEC4");
      node["skin"] = json["skins"].size();
      json["skins"].push_back({{"joints", nlohmann::json::array()}});
    }
    for (int k = 0; k < of.targets; ++k)
      primitive["targets"].push_back(
          {{"POSITION", parts.add_accessor(moves, 5126, count, "VEC3")}});
    json["meshes"].push_back({{"name", "mesh" + std::to_string(m)}, {"primitives", {primitive}}});
    roots.push_back(json["nodes"].size());
    json["nodes"].push_back(node);
    for (int j = 0; j < of.joints; ++j) {
      json["skins"].back()["joints"].push_back(json["nodes"].size());
      roots.push_back(json["nodes"].size());
      json["nodes"].push_back({{"name", "joint" + std::to_string(j)}});
    }
  }
  json["scenes"] = {{{"nodes", roots}}};
  return parts.glb();
}

}  // namespace planish::test
