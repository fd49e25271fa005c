// Based on: Khronos, "glTF 2.0 Specification", 2021.
#include "planish/files/gltf/gltf_document.h"

#include <tiny_gltf.h>

#include <cctype>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "planish/core/error.h"
#include "planish/core/version.h"
#include "planish/files/gltf/stored_position.h"

namespace planish {
namespace {

using tinygltf::Value;

constexpr double kRoughness = 0.5;

std::uint64_t padded(std::uint64_t bytes) { return (bytes + 3) / 4 * 4; }

template <class Vector>
std::vector<double> array_of(const Vector& v) {
  return {v.x, v.y, v.z};
}

// tinygltf throws where text is no UTF-8.
std::string valid_utf8(const std::string& text) {
  const nlohmann::json value = text;
  return nlohmann::json::parse(value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace))
      .get<std::string>();
}

Value value_of(const std::variant<bool, std::int64_t, double, std::string>& held) {
  if (const auto* flag = std::get_if<bool>(&held)) return Value(*flag);
  if (const auto* number = std::get_if<double>(&held)) return Value(*number);
  if (const auto* text = std::get_if<std::string>(&held)) return Value(valid_utf8(*text));
  const std::int64_t integer = std::get<std::int64_t>(held);
  // tinygltf's integers have 32 bits.
  const int narrow = static_cast<int>(integer);
  return narrow == integer ? Value(narrow) : Value(static_cast<double>(integer));
}

tinygltf::Asset asset_of(const GltfOptions& options) {
  tinygltf::Asset asset;
  asset.version = "2.0";
  asset.generator = "planish " PLANISH_VERSION;
  Value::Object extras;
  for (const auto& [key, held] : options.extras) extras[valid_utf8(key)] = value_of(held);
  if (!extras.empty()) asset.extras = Value(std::move(extras));
  return asset;
}

tinygltf::Node node_of(const GltfOptions& options) {
  tinygltf::Node node;
  node.mesh = 0;
  node.name = valid_utf8(options.name);
  if (options.origin != glm::dvec3(0.0))
    node.translation = array_of(StoredPosition(options).translation());
  return node;
}

// Attributes of all primitives in the order of their buffer views and accessors.
struct Attribute {
  std::string name;
  int type;
  std::uint64_t bytes;  // of a vertex
};

std::vector<Attribute> attributes_of(const GltfLayout& layout) {
  std::vector<Attribute> attributes{{"POSITION", TINYGLTF_TYPE_VEC3, 12},
                                    {"NORMAL", TINYGLTF_TYPE_VEC3, 12}};
  if (layout.has_uvs) attributes.push_back({"TEXCOORD_0", TINYGLTF_TYPE_VEC2, 8});
  if (layout.has_colors) attributes.push_back({"COLOR_0", TINYGLTF_TYPE_VEC4, 16});
  for (const std::string& field : layout.fields)
    attributes.push_back({field, TINYGLTF_TYPE_SCALAR, 4});
  return attributes;
}

void add_buffer_views(const GltfLayout& layout, tinygltf::Model& model) {
  std::uint64_t offset = 0;
  const auto add = [&](std::uint64_t bytes, int target) {
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = offset;
    view.byteLength = bytes;
    view.target = target;
    model.bufferViews.push_back(std::move(view));
    offset += padded(bytes);
  };
  for (const Attribute& attribute : attributes_of(layout))
    add(attribute.bytes * layout.vertex_count, TINYGLTF_TARGET_ARRAY_BUFFER);
  for (std::size_t i = 0; i < layout.primitives.size(); ++i)
    add(layout.index_bytes(i), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
}

void add_accessors(const GltfLayout& layout, const GltfBounds& bounds, tinygltf::Model& model) {
  const auto add = [&](int component, std::uint64_t count, int type) -> tinygltf::Accessor& {
    tinygltf::Accessor& accessor = model.accessors.emplace_back();
    accessor.bufferView = static_cast<int>(model.accessors.size()) - 1;
    accessor.componentType = component;
    accessor.count = count;
    accessor.type = type;
    return accessor;
  };
  for (const Attribute& attribute : attributes_of(layout))
    add(TINYGLTF_COMPONENT_TYPE_FLOAT, layout.vertex_count, attribute.type);
  model.accessors[0].minValues = array_of(bounds.minimum);
  model.accessors[0].maxValues = array_of(bounds.maximum);
  for (const GltfPrimitive& primitive : layout.primitives) {
    add(layout.index_size == 2 ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                               : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
        3 * primitive.triangle_count, TINYGLTF_TYPE_SCALAR);
  }
}

tinygltf::Mesh mesh_of(const GltfLayout& layout, const GltfOptions& options) {
  const std::vector<Attribute> attributes = attributes_of(layout);
  tinygltf::Mesh mesh;
  mesh.name = valid_utf8(options.name);
  for (std::size_t i = 0; i < layout.primitives.size(); ++i) {
    tinygltf::Primitive& primitive = mesh.primitives.emplace_back();
    for (std::size_t k = 0; k < attributes.size(); ++k)
      primitive.attributes[valid_utf8(attributes[k].name)] = static_cast<int>(k);
    primitive.indices = static_cast<int>(attributes.size() + i);
    primitive.material = static_cast<int>(i);
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    // Primitives have no name of their own.
    const std::string& name = layout.primitives[i].name;
    if (!name.empty()) primitive.extras = Value(Value::Object{{"group", Value(valid_utf8(name))}});
  }
  return mesh;
}

void add_materials(const GltfLayout& layout, const GltfOptions& options, tinygltf::Model& model) {
  for (const GltfPrimitive& primitive : layout.primitives) {
    tinygltf::Material& material = model.materials.emplace_back();
    material.pbrMetallicRoughness.metallicFactor = 0.0;
    material.pbrMetallicRoughness.roughnessFactor = kRoughness;
    material.doubleSided = options.double_sided;
    material.name = valid_utf8(primitive.material.empty() ? primitive.name : primitive.material);
  }
}

// The document without its buffers.
nlohmann::json serialised(const tinygltf::Model& model) {
  std::ostringstream text;
  tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, text, false, false);
  return nlohmann::json::parse(text.str());
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
  tinygltf::Model model;
  model.asset = asset_of(options);
  model.defaultScene = 0;
  model.scenes.emplace_back().nodes = {0};
  model.nodes = {node_of(options)};
  model.meshes = {mesh_of(layout, options)};
  add_materials(layout, options, model);
  add_accessors(layout, bounds, model);
  add_buffer_views(layout, model);
  nlohmann::json document = serialised(model);
  // tinygltf sizes a buffer by the bytes that it holds, and ours are still to be made.
  nlohmann::json buffer{{"byteLength", layout.buffer_bytes}};
  if (!buffer_uri.empty()) buffer["uri"] = buffer_uri;
  document["buffers"] = nlohmann::json::array({std::move(buffer)});
  return document.dump(buffer_uri.empty() ? -1 : 2);
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
