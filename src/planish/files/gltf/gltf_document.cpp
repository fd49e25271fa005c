// Based on: Khronos, "glTF 2.0 Specification", 2021.
#include "planish/files/gltf/gltf_document.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "planish/core/version.h"
#include "planish/files/gltf/gltf_materials.h"

namespace planish {
namespace {

using nlohmann::json;

constexpr double kRoughness = 0.5;
constexpr int kTriangles = 4, kArrayBuffer = 34962, kElementArrayBuffer = 34963;

constexpr std::string_view kMeshopt = "EXT_meshopt_compression";

template <class Vector>
json array_of(const Vector& v) {
  return {v.x, v.y, v.z};
}

template <class Vector>
json integers_of(const Vector& v) {
  return {static_cast<int>(v.x), static_cast<int>(v.y), static_cast<int>(v.z)};
}

json asset_of(const GltfOptions& options) {
  json asset;
  asset["version"] = "2.0";
  asset["generator"] = "planish " PLANISH_VERSION;
  for (const auto& [key, held] : options.extras)
    std::visit([&, &to = asset["extras"][key]](const auto& value) { to = value; }, held);
  return asset;
}

void set_name(json& to, const std::string& name) {
  if (!name.empty()) to["name"] = name;
}

// Of a mesh and its node.
std::string name_of(const GltfDocument& document, const GltfOptions& options, std::size_t mesh) {
  return options.name + (document.mesh_count > 1 ? " " + std::to_string(mesh + 1) : "");
}

json node_of(const GltfDocument& document, const GltfOptions& options, std::size_t mesh) {
  json node;
  node["mesh"] = mesh;
  set_name(node, name_of(document, options, mesh));
  if (document.translation != glm::dvec3(0.0)) node["translation"] = array_of(document.translation);
  if (document.scale != 1.0) node["scale"] = array_of(glm::dvec3(document.scale));
  return node;
}

json buffer_view_of(const GltfArray& array) {
  json view;
  view["buffer"] = array.stream ? 1 : array.buffer;
  view["byteLength"] = array.bytes;
  if (array.offset > 0) view["byteOffset"] = array.offset;
  if (array.stride > 0) view["byteStride"] = array.stride;
  view["target"] = array.is_indices ? kElementArrayBuffer : kArrayBuffer;
  return view;
}

json accessor_of(const GltfArray& array, std::size_t view) {
  json accessor;
  accessor["bufferView"] = view;
  accessor["componentType"] = static_cast<int>(array.component);
  accessor["count"] = array.count;
  accessor["type"] = array.type;
  if (array.normalized) accessor["normalized"] = true;
  if (!array.bounds) return accessor;
  const bool is_float = array.component == GltfComponent::Float;
  for (const auto& [key, bound] :
       {std::pair("min", array.bounds->minimum), std::pair("max", array.bounds->maximum)})
    accessor[key] = is_float ? array_of(glm::dvec3(bound)) : integers_of(bound);
  return accessor;
}

const std::string& material_name(const GltfArrays& primitive) {
  return primitive.material.empty() ? primitive.name : primitive.material;
}

// Materials of the primitives, each with its number.
std::vector<std::size_t> add_materials(const GltfDocument& document, const GltfOptions& options,
                                       json& to) {
  std::vector<std::size_t> numbers;
  std::map<std::string, std::size_t> known;
  json& materials = to["materials"];
  for (const GltfArrays& primitive : document.primitives) {
    const std::string& name = material_name(primitive);
    const std::size_t next = materials.size();
    const auto [entry, is_new] = known.try_emplace(name, next);
    numbers.push_back(document.shares_materials ? entry->second : next);
    if (document.shares_materials && !is_new) continue;
    json material;
    material["pbrMetallicRoughness"] = {{"metallicFactor", 0.0}, {"roughnessFactor", kRoughness}};
    if (options.double_sided) material["doubleSided"] = true;
    set_name(material, name);
    materials.push_back(std::move(material));
  }
  return numbers;
}

void add_meshes(const GltfDocument& document, const GltfOptions& options, json& to) {
  json &nodes = to["nodes"], &scene = to["scenes"][0]["nodes"], &meshes = to["meshes"];
  for (std::size_t m = 0; m < document.mesh_count; ++m) {
    nodes.push_back(node_of(document, options, m));
    scene.push_back(m);
    set_name(meshes[m], name_of(document, options, m));
  }
  const std::vector<std::size_t> materials = add_materials(document, options, to);
  for (std::size_t i = 0; i < document.primitives.size(); ++i) {
    const GltfArrays& arrays = document.primitives[i];
    json primitive;
    primitive["attributes"] = arrays.attributes;
    primitive["indices"] = arrays.indices;
    primitive["material"] = materials[i];
    primitive["mode"] = kTriangles;
    // Primitives have no name of their own.
    if (!arrays.name.empty()) primitive["extras"]["group"] = arrays.name;
    meshes[arrays.mesh]["primitives"].push_back(std::move(primitive));
  }
}

// Without their bytes; and where streams lie.
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
    to["bufferViews"][i]["extensions"][std::string(kMeshopt)] = std::move(stream);
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
  json written;
  written["asset"] = asset_of(options);
  written["scene"] = 0;
  add_meshes(document, options, written);
  if (!document.extensions.empty())
    written["extensionsUsed"] = written["extensionsRequired"] = document.extensions;
  for (std::size_t i = 0; i < document.arrays.size(); ++i) {
    written["bufferViews"].push_back(buffer_view_of(document.arrays[i]));
    written["accessors"].push_back(accessor_of(document.arrays[i], i));
  }
  add_buffers(document, buffer_uri, written);
  if (takes_materials(document, options))
    options.materials->apply(written, options.image_folder, document.buffer_bytes);
  return written.dump(buffer_uri.empty() ? -1 : 2, ' ', false, json::error_handler_t::replace);
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
