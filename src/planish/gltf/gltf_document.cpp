// Based on: Khronos, "glTF 2.0 Specification", 2021.
#include "planish/gltf/gltf_document.h"

#include <array>
#include <cctype>
#include <limits>
#include <nlohmann/json.hpp>

#include "planish/core/error.h"
#include "planish/core/version.h"
#include "planish/gltf/stored_position.h"

namespace planish {
namespace {

using nlohmann::json;

// Of the glTF specification, section 5.
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kTriangles = 4;

constexpr double kRoughness = 0.5;

std::uint64_t padded(std::uint64_t bytes) { return (bytes + 3) / 4 * 4; }

template <class Vector>
json array_of(const Vector& v) {
  return json::array({v.x, v.y, v.z});
}

json asset_of(const GltfOptions& options) {
  json asset{{"version", "2.0"}, {"generator", "planish " PLANISH_VERSION}};
  for (const auto& [key, value] : options.extras) {
    std::visit([&](const auto& held) { asset["extras"][key] = held; }, value);
  }
  return asset;
}

json node_of(const GltfOptions& options) {
  json node{{"mesh", 0}, {"name", options.name}};
  if (options.origin != glm::dvec3(0.0)) {
    node["translation"] = array_of(StoredPosition(options).translation());
  }
  return node;
}

json buffer_views_of(const GltfLayout& layout) {
  const auto attribute = [&](std::uint64_t offset) {
    return json{{"buffer", 0},
                {"byteOffset", offset},
                {"byteLength", layout.attribute_bytes},
                {"target", kArrayBuffer}};
  };
  return json::array({attribute(0), attribute(layout.attribute_bytes),
                      json{{"buffer", 0},
                           {"byteOffset", 2 * layout.attribute_bytes},
                           {"byteLength", layout.index_bytes},
                           {"target", kElementArrayBuffer}}});
}

json accessors_of(const GltfLayout& layout, const GltfBounds& bounds) {
  json positions{
      {"bufferView", 0}, {"componentType", kFloat},         {"count", layout.vertex_count},
      {"type", "VEC3"},  {"min", array_of(bounds.minimum)}, {"max", array_of(bounds.maximum)}};
  json normals{{"bufferView", 1},
               {"componentType", kFloat},
               {"count", layout.vertex_count},
               {"type", "VEC3"}};
  json indices{{"bufferView", 2},
               {"componentType", layout.index_size == 2 ? kUnsignedShort : kUnsignedInt},
               {"count", 3 * layout.triangle_count},
               {"type", "SCALAR"}};
  return json::array({std::move(positions), std::move(normals), std::move(indices)});
}

}  // namespace

GltfLayout gltf_layout(std::uint64_t vertex_count, std::uint64_t triangle_count) {
  GltfLayout layout;
  layout.vertex_count = vertex_count;
  layout.triangle_count = triangle_count;
  layout.index_size = vertex_count <= kMaxShortIndexVertices ? 2 : 4;
  layout.attribute_bytes = 3 * sizeof(float) * vertex_count;
  layout.index_bytes = 3 * layout.index_size * triangle_count;
  layout.buffer_bytes = 2 * layout.attribute_bytes + padded(layout.index_bytes);
  return layout;
}

std::uint64_t glb_byte_count(std::uint64_t json_bytes, std::uint64_t buffer_bytes,
                             std::string_view name) {
  const std::uint64_t bytes =
      kGlbHeaderBytes + 2 * kGlbChunkHeaderBytes + padded(json_bytes) + padded(buffer_bytes);
  if (bytes > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(ErrorCode::InvalidArgument,
                std::string(name) + ": " + std::to_string(bytes) +
                    " bytes are more than a .glb file can hold (4294967295); write .gltf, whose "
                    ".bin has no such limit, or use fewer levels");
  }
  return bytes;
}

std::string gltf_json(const GltfLayout& layout, const GltfBounds& bounds,
                      const GltfOptions& options, std::string_view buffer_uri) {
  json primitive{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}},
                 {"indices", 2},
                 {"material", 0},
                 {"mode", kTriangles}};
  json mesh{{"name", options.name}, {"primitives", json::array({std::move(primitive)})}};
  json material{
      {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", kRoughness}}}};
  if (options.double_sided) material["doubleSided"] = true;
  json scene{{"nodes", json::array({0})}};
  json document;
  document["asset"] = asset_of(options);
  document["scene"] = 0;
  document["scenes"] = json::array({std::move(scene)});
  document["nodes"] = json::array({node_of(options)});
  document["meshes"] = json::array({std::move(mesh)});
  document["materials"] = json::array({std::move(material)});
  document["accessors"] = accessors_of(layout, bounds);
  document["bufferViews"] = buffer_views_of(layout);
  json buffer{{"byteLength", layout.buffer_bytes}};
  if (!buffer_uri.empty()) buffer["uri"] = buffer_uri;
  document["buffers"] = json::array({std::move(buffer)});
  return document.dump(buffer_uri.empty() ? -1 : 2, ' ', false, json::error_handler_t::replace);
}

std::string encode_uri(std::string_view file_name) {
  constexpr std::string_view kHexDigits = "0123456789ABCDEF";
  constexpr std::string_view kUnreserved = "-._~";
  std::string uri;
  for (const char c : file_name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain =
        byte < 128 && (std::isalnum(byte) || kUnreserved.find(c) != kUnreserved.npos);
    if (plain) {
      uri += c;
    } else {
      uri += {'%', kHexDigits[byte / 16], kHexDigits[byte % 16]};
    }
  }
  return uri;
}

}  // namespace planish
