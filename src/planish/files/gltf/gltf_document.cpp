// Based on: Khronos, "glTF 2.0 Specification", 2021.
#include "planish/files/gltf/gltf_document.h"

#include <cctype>
#include <limits>
#include <nlohmann/json.hpp>

#include "planish/core/error.h"
#include "planish/core/version.h"
#include "planish/files/gltf/stored_position.h"

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
    json& entry = asset["extras"][key];
    std::visit([&](const auto& held) { entry = held; }, value);
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

// Attributes of all primitives in the order of their buffer views and accessors.
struct Attribute {
  std::string name;
  const char* type;
  std::uint64_t bytes;  // of a vertex
};

std::vector<Attribute> attributes_of(const GltfLayout& layout) {
  std::vector<Attribute> attributes{{"POSITION", "VEC3", 12}, {"NORMAL", "VEC3", 12}};
  if (layout.has_uvs) attributes.push_back({"TEXCOORD_0", "VEC2", 8});
  if (layout.has_colors) attributes.push_back({"COLOR_0", "VEC4", 16});
  for (const std::string& field : layout.fields) attributes.push_back({field, "SCALAR", 4});
  return attributes;
}

json buffer_views_of(const GltfLayout& layout) {
  json views = json::array();
  std::uint64_t offset = 0;
  const auto add = [&](std::uint64_t bytes, int target) {
    views.push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}, {"target", target}});
    offset += padded(bytes);
  };
  for (const Attribute& attribute : attributes_of(layout))
    add(attribute.bytes * layout.vertex_count, kArrayBuffer);
  for (std::size_t i = 0; i < layout.primitives.size(); ++i)
    add(layout.index_bytes(i), kElementArrayBuffer);
  return views;
}

json accessors_of(const GltfLayout& layout, const GltfBounds& bounds) {
  json accessors = json::array();
  for (const Attribute& attribute : attributes_of(layout)) {
    accessors.push_back({{"bufferView", accessors.size()},
                         {"componentType", kFloat},
                         {"count", layout.vertex_count},
                         {"type", attribute.type}});
  }
  accessors[0]["min"] = array_of(bounds.minimum);
  accessors[0]["max"] = array_of(bounds.maximum);
  for (const GltfPrimitive& primitive : layout.primitives) {
    accessors.push_back({{"bufferView", accessors.size()},
                         {"componentType", layout.index_size == 2 ? kUnsignedShort : kUnsignedInt},
                         {"count", 3 * primitive.triangle_count},
                         {"type", "SCALAR"}});
  }
  return accessors;
}

json primitives_of(const GltfLayout& layout) {
  const std::vector<Attribute> attributes = attributes_of(layout);
  json accessor_of = json::object();
  for (std::size_t i = 0; i < attributes.size(); ++i) accessor_of[attributes[i].name] = i;
  json primitives = json::array();
  for (std::size_t i = 0; i < layout.primitives.size(); ++i) {
    json primitive{{"attributes", accessor_of},
                   {"indices", attributes.size() + i},
                   {"material", i},
                   {"mode", kTriangles}};
    // Primitives have no name of their own.
    if (!layout.primitives[i].name.empty())
      primitive["extras"] = {{"group", layout.primitives[i].name}};
    primitives.push_back(std::move(primitive));
  }
  return primitives;
}

json materials_of(const GltfLayout& layout, const GltfOptions& options) {
  json materials = json::array();
  for (const GltfPrimitive& primitive : layout.primitives) {
    json material{
        {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", kRoughness}}}};
    if (options.double_sided) material["doubleSided"] = true;
    const std::string& name = primitive.material.empty() ? primitive.name : primitive.material;
    if (!name.empty()) material["name"] = name;
    materials.push_back(std::move(material));
  }
  return materials;
}

}  // namespace

GltfLayout gltf_layout(std::uint64_t vertex_count, std::uint64_t triangle_count) {
  GltfLayout layout;
  layout.vertex_count = vertex_count;
  layout.primitives = {{.triangle_count = triangle_count, .name = {}, .material = {}}};
  set_sizes(layout);
  return layout;
}

void set_sizes(GltfLayout& layout) {
  layout.index_size = layout.vertex_count <= kMaxShortIndexVertices ? 2 : 4;
  layout.attribute_bytes = 3 * sizeof(float) * layout.vertex_count;
  layout.triangle_count = layout.buffer_bytes = 0;
  for (const Attribute& attribute : attributes_of(layout))
    layout.buffer_bytes += attribute.bytes * layout.vertex_count;
  for (std::size_t i = 0; i < layout.primitives.size(); ++i) {
    layout.triangle_count += layout.primitives[i].triangle_count;
    layout.buffer_bytes += padded(layout.index_bytes(i));
  }
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
  json mesh{{"name", options.name}, {"primitives", primitives_of(layout)}};
  json scene{{"nodes", json::array({0})}};
  json document;
  document["asset"] = asset_of(options);
  document["scene"] = 0;
  document["scenes"] = json::array({std::move(scene)});
  document["nodes"] = json::array({node_of(options)});
  document["meshes"] = json::array({std::move(mesh)});
  document["materials"] = materials_of(layout, options);
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
