#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "files/gltf/glb_bytes.h"
#include "planish/core/json.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// What rides on a mesh of a large asset.
struct Riders {
  int joints = 0, targets = 0;
};

/// A GLB of triangulated meshes, each in a node of its own. Of joints two move each vertex, as they
/// follow one another along the vertices; targets move all vertices.
inline std::string large_asset(const std::vector<PolygonMesh>& meshes,
                               const std::vector<Riders>& riders = {}) {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
  std::string bytes;
  const auto add = [&](const std::string& view, int component, std::size_t count,
                       const char* type) {
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", view.size()}});
    bytes += view;
    json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                 {"componentType", component},
                                 {"count", count},
                                 {"type", type}});
    return json["accessors"].size() - 1;
  };
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
    nlohmann::json primitive = {{"attributes", {{"POSITION", add(points, 5126, count, "VEC3")}}},
                                {"indices", add(corners, 5125, corner_count, "SCALAR")}};
    nlohmann::json node = {{"mesh", m}};
    if (of.joints > 0) {
      primitive["attributes"]["JOINTS_0"] = add(joints, 5123, count, "VEC4");
      primitive["attributes"]["WEIGHTS_0"] = add(weights, 5126, count, "VEC4");
      node["skin"] = json["skins"].size();
      json["skins"].push_back({{"joints", nlohmann::json::array()}});
    }
    for (int k = 0; k < of.targets; ++k)
      primitive["targets"].push_back({{"POSITION", add(moves, 5126, count, "VEC3")}});
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
  json["buffers"] = {{{"byteLength", bytes.size()}}};
  return glb_of(json.dump(), bytes);
}

}  // namespace planish::test
