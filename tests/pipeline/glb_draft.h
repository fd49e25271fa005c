#pragma once

#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "files/gltf/glb_bytes.h"

namespace planish::test {

/// A GLB with one mesh, whose primitives a test adds, and the accessors that they name.
struct GlbDraft {
  std::string bytes;
  nlohmann::json document = {{"asset", {{"version", "2.0"}}},
                             {"scenes", {{{"nodes", {0}}}}},
                             {"nodes", {{{"mesh", 0}}}},
                             {"bufferViews", nlohmann::json::array()},
                             {"accessors", nlohmann::json::array()}};

  /// The number of the accessor.
  std::size_t add(int component, std::size_t count, std::size_t width, const std::string& view) {
    constexpr std::array kTypes{"SCALAR", "VEC2", "VEC3", "VEC4"};
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", view.size()}});
    document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                     {"componentType", component},
                                     {"count", count},
                                     {"type", kTypes[width - 1]}});
    bytes += view;
    return document["accessors"].size() - 1;
  }
  /// `width` a vertex.
  std::size_t add_floats(const std::vector<double>& values, std::size_t width) {
    std::string view;
    for (const double value : values) append<float>(view, static_cast<float>(value));
    return add(5126, values.size() / width, width, view);
  }
  std::size_t add_positions(std::span<const glm::dvec3> positions) {
    std::vector<double> values;
    glm::dvec3 low(positions.front()), high(low);
    for (const glm::dvec3& p : positions) {
      values.insert(values.end(), {p.x, p.y, p.z});
      low = glm::min(low, p), high = glm::max(high, p);
    }
    const std::size_t number = add_floats(values, 3);
    document["accessors"][number]["min"] = {low.x, low.y, low.z};
    document["accessors"][number]["max"] = {high.x, high.y, high.z};
    return number;
  }
  std::size_t add_indices(std::span<const std::int32_t> indices) {
    std::string view;
    for (const std::int32_t v : indices) append<std::uint32_t>(view, static_cast<std::uint32_t>(v));
    return add(5125, indices.size(), 1, view);
  }
  void add_primitive(nlohmann::json primitive) {
    document["meshes"][0]["primitives"].push_back(std::move(primitive));
  }
  [[nodiscard]] std::string glb() {
    document["buffers"] = {{{"byteLength", bytes.size()}}};
    return glb_of(document.dump(), bytes);
  }
};

}  // namespace planish::test
