#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string>

#include "planish/core/json.h"
#include "support/files.h"

namespace planish::test {

inline std::string glb_of(std::string json, std::string chunk) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  chunk.resize((chunk.size() + 3) / 4 * 4, '\0');
  std::string bytes = "glTF";
  append<std::uint32_t>(bytes, 2);
  append<std::uint32_t>(bytes, static_cast<std::uint32_t>(28 + json.size() + chunk.size()));
  append<std::uint32_t>(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  append<std::uint32_t>(bytes, static_cast<std::uint32_t>(chunk.size()));
  return bytes + std::string("BIN\0", 4) + chunk;
}

/// A GLB that is made part by part.
struct GlbParts {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}};
  std::string bytes;

  std::size_t add_view(const std::string& view) {
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", view.size()}});
    bytes += view;
    return json["bufferViews"].size() - 1;
  }
  std::size_t add_accessor(const std::string& view, int component, std::size_t count,
                           const char* type) {
    json["accessors"].push_back({{"bufferView", add_view(view)},
                                 {"componentType", component},
                                 {"count", count},
                                 {"type", type}});
    return json["accessors"].size() - 1;
  }
  [[nodiscard]] std::string glb() {
    json["buffers"] = {{{"byteLength", bytes.size()}}};
    return glb_of(json.dump(), bytes);
  }
};

/// The JSON of a GLB.
inline nlohmann::json document_of(const std::string& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof(length));
  return nlohmann::json::parse(glb.substr(20, length));
}

template <class Value>
std::string values(std::initializer_list<double> list) {
  std::string bytes;
  for (const double value : list) append<Value>(bytes, static_cast<Value>(value));
  return bytes;
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

/// Four corners of a unit square: 48 bytes of positions, then the indices 0 1 2 0 2 3 as u16.
inline std::string square_chunk() {
  return values<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) +
         values<std::uint16_t>({0, 1, 2, 0, 2, 3});
}

inline std::string square_json() {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
         R"("nodes":[{"mesh":0}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
         R"("accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
         R"({"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":48},)"
         R"({"buffer":0,"byteOffset":48,"byteLength":12}],"buffers":[{"byteLength":60}]})";
}

inline GlbParts square_parts() { return {nlohmann::json::parse(square_json()), square_chunk()}; }

}  // namespace planish::test
