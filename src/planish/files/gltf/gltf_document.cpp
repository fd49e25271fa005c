// Based on: Khronos, "glTF 2.0 Specification", 2021.
#include "planish/files/gltf/gltf_document.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "planish/core/formatted.h"
#include "planish/core/json.h"
#include "planish/core/version.h"
#include "planish/files/gltf/gltf_materials.h"

// tinygltf with a JSON that is taken apart without memory, and without the streams that its library
// writes to. What it includes itself stands above; what is not called here is not compiled.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
namespace {
#include <tiny_gltf.h>
}

namespace planish {
namespace {

using nlohmann::json;
using tinygltf::Value;

constexpr double kRoughness = 0.5;

constexpr std::string_view kMeshopt = "EXT_meshopt_compression";

template <class Vector>
std::vector<double> array_of(const Vector& v) {
  return {v.x, v.y, v.z};
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

// Of a mesh and its node.
std::string name_of(const GltfDocument& document, const GltfOptions& options, std::size_t mesh) {
  const std::string number = document.mesh_count > 1 ? formatted(" {}", mesh + 1) : "";
  return valid_utf8(options.name + number);
}

tinygltf::Node node_of(const GltfDocument& document, const GltfOptions& options, std::size_t mesh) {
  tinygltf::Node node;
  node.mesh = static_cast<int>(mesh);
  node.name = name_of(document, options, mesh);
  if (document.translation != glm::dvec3(0.0)) node.translation = array_of(document.translation);
  if (document.scale != 1.0) node.scale = array_of(glm::dvec3(document.scale));
  return node;
}

int type_of(std::string_view name) {
  if (name == "SCALAR") return TINYGLTF_TYPE_SCALAR;
  if (name == "VEC2") return TINYGLTF_TYPE_VEC2;
  return name == "VEC3" ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_VEC4;
}

void add_arrays(const GltfDocument& document, tinygltf::Model& model) {
  for (std::size_t i = 0; i < document.arrays.size(); ++i) {
    const GltfArray& array = document.arrays[i];
    tinygltf::BufferView& view = model.bufferViews.emplace_back();
    view.buffer = array.stream ? 1 : static_cast<int>(array.buffer);
    if (!array.stream) view.byteOffset = static_cast<std::size_t>(array.offset);
    view.byteLength = static_cast<std::size_t>(array.bytes);
    view.byteStride = array.stride;
    view.target =
        array.is_indices ? TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER : TINYGLTF_TARGET_ARRAY_BUFFER;
    tinygltf::Accessor& accessor = model.accessors.emplace_back();
    accessor.bufferView = static_cast<int>(i);
    accessor.componentType = static_cast<int>(array.component);
    accessor.normalized = array.normalized;
    accessor.count = static_cast<std::size_t>(array.count);
    accessor.type = type_of(array.type);
    if (!array.bounds) continue;
    accessor.minValues = array_of(array.bounds->minimum);
    accessor.maxValues = array_of(array.bounds->maximum);
  }
}

std::string material_name(const GltfArrays& primitive) {
  return valid_utf8(primitive.material.empty() ? primitive.name : primitive.material);
}

// Materials of the primitives, each with its number.
std::vector<int> add_materials(const GltfDocument& document, const GltfOptions& options,
                               tinygltf::Model& model) {
  std::vector<int> numbers;
  std::map<std::string, int> known;
  for (const GltfArrays& primitive : document.primitives) {
    std::string name = material_name(primitive);
    const auto next = static_cast<int>(model.materials.size());
    const auto [entry, is_new] = known.try_emplace(name, next);
    numbers.push_back(document.shares_materials ? entry->second : next);
    if (document.shares_materials && !is_new) continue;
    tinygltf::Material& material = model.materials.emplace_back();
    material.pbrMetallicRoughness.metallicFactor = 0.0;
    material.pbrMetallicRoughness.roughnessFactor = kRoughness;
    material.doubleSided = options.double_sided;
    material.name = std::move(name);
  }
  return numbers;
}

void add_meshes(const GltfDocument& document, const GltfOptions& options, tinygltf::Model& model) {
  const std::vector<int> materials = add_materials(document, options, model);
  for (std::size_t m = 0; m < document.mesh_count; ++m) {
    model.nodes.push_back(node_of(document, options, m));
    model.scenes.front().nodes.push_back(static_cast<int>(m));
    model.meshes.emplace_back().name = name_of(document, options, m);
  }
  for (std::size_t i = 0; i < document.primitives.size(); ++i) {
    const GltfArrays& arrays = document.primitives[i];
    tinygltf::Primitive& primitive = model.meshes[arrays.mesh].primitives.emplace_back();
    for (const auto& [name, array] : arrays.attributes)
      primitive.attributes[valid_utf8(name)] = static_cast<int>(array);
    primitive.indices = static_cast<int>(arrays.indices);
    primitive.material = materials[i];
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    // Primitives have no name of their own.
    if (!arrays.name.empty())
      primitive.extras = Value(Value::Object{{"group", Value(valid_utf8(arrays.name))}});
  }
}

// What tinygltf cannot serialise: buffers without their bytes, extensions of buffer views, and
// places in a buffer that streams stand for: it may be larger than the 32 bits of WebAssembly.
void add_buffers(const GltfDocument& document, std::string_view uri, json& to) {
  json& buffers = to["buffers"] = json::array();
  for (const GltfBuffer& buffer : document.buffers)
    buffers.push_back({{"byteLength", buffer.bytes}, {"uri", buffer.uri}});
  if (!document.buffers.empty()) return;
  buffers.push_back({{"byteLength", document.buffer_bytes}});
  if (!uri.empty()) buffers[0]["uri"] = uri;
  if (document.decoded_bytes == 0) return;
  buffers.push_back(
      {{"byteLength", document.decoded_bytes}, {"extensions", {{kMeshopt, {{"fallback", true}}}}}});
  for (std::size_t i = 0; i < document.arrays.size(); ++i) {
    const GltfArray& array = document.arrays[i];
    if (!array.stream) continue;
    json stream{{"buffer", 0},
                {"byteOffset", array.stream->offset},
                {"byteLength", array.stream->bytes},
                {"byteStride", array.bytes / array.count},
                {"count", array.count},
                {"mode", array.stream->mode}};
    if (array.stream->filter != "NONE") stream["filter"] = array.stream->filter;
    json& view = to["bufferViews"][i];
    if (array.offset > 0) view["byteOffset"] = array.offset;
    view["extensions"][std::string(kMeshopt)] = std::move(stream);
  }
}

// Where the parts of a block come.
struct BlockPlace {
  std::uint32_t buffer = 0;
  std::uint64_t buffer_offset = 0;
  std::size_t mesh = 0;
};

void append_arrays(const GltfDocument& block, const BlockPlace& place, GltfDocument& all) {
  const std::size_t first = all.arrays.size();
  for (GltfArray array : block.arrays) {
    array.buffer = place.buffer;
    // The arrays that streams stand for lie in a buffer of their own.
    array.offset += array.stream ? all.decoded_bytes : place.buffer_offset;
    if (array.stream) array.stream->offset += place.buffer_offset;
    all.arrays.push_back(array);
  }
  for (GltfArrays primitive : block.primitives) {
    for (auto& [name, array] : primitive.attributes) array += first;
    primitive.indices += first;
    primitive.mesh = place.mesh;
    all.primitives.push_back(std::move(primitive));
  }
  all.buffer_bytes += block.buffer_bytes;
  all.decoded_bytes += block.decoded_bytes;
}

}  // namespace

bool takes_materials(const GltfDocument& document, const GltfOptions& options) {
  return options.materials != nullptr && document.buffers.empty() &&
         std::ranges::any_of(document.primitives, [&](const GltfArrays& primitive) {
           return options.materials->has(material_name(primitive));
         });
}

std::string gltf_json(const GltfDocument& document, const GltfOptions& options,
                      std::string_view buffer_uri) {
  tinygltf::Model model;
  model.asset = asset_of(options);
  model.defaultScene = 0;
  model.scenes.emplace_back();
  add_meshes(document, options, model);
  model.extensionsUsed = model.extensionsRequired = document.extensions;
  add_arrays(document, model);
  json written;
  tinygltf::SerializeGltfModel(&model, written);
  add_buffers(document, buffer_uri, written);
  if (takes_materials(document, options))
    options.materials->apply(written, options.image_folder, document.buffer_bytes);
  return written.dump(buffer_uri.empty() ? -1 : 2);
}

void append(GltfDocument& all, const GltfDocument& block) {
  append_arrays(block, {.buffer_offset = all.buffer_bytes, .mesh = all.mesh_count - 1}, all);
}

void append_mesh(GltfDocument& all, const GltfDocument& block, std::string uri) {
  const std::size_t number = all.buffers.size();
  append_arrays(block, {.buffer = static_cast<std::uint32_t>(number), .mesh = number}, all);
  all.buffers.push_back({block.buffer_bytes, std::move(uri)});
  all.mesh_count = number + 1;
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
