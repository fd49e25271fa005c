// Based on: Khronos, "glTF 2.0 Specification", 2021.
#include "planish/files/gltf/gltf_document.h"

#include <cctype>
#include <map>
#include <nlohmann/json.hpp>

#include "planish/core/version.h"

namespace planish {
namespace {

using nlohmann::json;

constexpr double kRoughness = 0.5;
constexpr int kTriangleMode = 4, kArrayBuffer = 34962, kElementArrayBuffer = 34963;

constexpr std::string_view kMeshopt = "EXT_meshopt_compression";

json array_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

// As numbers of the accessor's kind.
json array_of(const glm::vec3& v, GltfComponent component) {
  if (component == GltfComponent::Float) return array_of(v);
  return {static_cast<int>(v.x), static_cast<int>(v.y), static_cast<int>(v.z)};
}

json asset_of(const GltfOptions& options) {
  json asset{{"version", "2.0"}, {"generator", "planish " PLANISH_VERSION}};
  for (const auto& [key, held] : options.extras)
    std::visit([&](const auto& value) { asset["extras"][key] = value; }, held);
  return asset;
}

void add_arrays(const GltfDocument& document, json& to) {
  for (std::size_t i = 0; i < document.arrays.size(); ++i) {
    const GltfArray& array = document.arrays[i];
    json& view =
        to["bufferViews"][i] = {{"buffer", array.stream ? 1 : array.buffer},
                                {"byteLength", array.bytes},
                                {"target", array.is_indices ? kElementArrayBuffer : kArrayBuffer}};
    if (array.offset > 0) view["byteOffset"] = array.offset;
    if (array.stride > 0) view["byteStride"] = array.stride;
    if (array.stream) {
      json& stream =
          view["extensions"][std::string(kMeshopt)] = {{"buffer", 0},
                                                       {"byteOffset", array.stream->offset},
                                                       {"byteLength", array.stream->bytes},
                                                       {"byteStride", array.bytes / array.count},
                                                       {"count", array.count},
                                                       {"mode", array.stream->mode}};
      if (array.stream->filter != "NONE") stream["filter"] = array.stream->filter;
    }
    json& accessor = to["accessors"][i] = {{"bufferView", i},
                                           {"componentType", array.component},
                                           {"count", array.count},
                                           {"type", array.type}};
    if (array.normalized) accessor["normalized"] = true;
    if (!array.bounds) continue;
    accessor["min"] = array_of(array.bounds->minimum, array.component);
    accessor["max"] = array_of(array.bounds->maximum, array.component);
  }
}

// The number of a new material.
std::size_t add_material(const std::string& name, const GltfOptions& options, json& materials) {
  json& material = materials.emplace_back();
  material["pbrMetallicRoughness"] = {{"metallicFactor", 0.0}, {"roughnessFactor", kRoughness}};
  if (options.double_sided) material["doubleSided"] = true;
  if (!name.empty()) material["name"] = name;
  return materials.size() - 1;
}

void add_meshes(const GltfDocument& document, const GltfOptions& options, json& to) {
  json& nodes = to["nodes"] = json::array();
  json& meshes = to["meshes"] = json::array();
  for (std::size_t m = 0; m < document.mesh_count; ++m) {
    const std::string number = document.mesh_count > 1 ? " " + std::to_string(m + 1) : "";
    json& node = nodes.emplace_back(json{{"mesh", m}});
    json& mesh = meshes.emplace_back(json{{"primitives", json::array()}});
    if (!(options.name + number).empty()) node["name"] = mesh["name"] = options.name + number;
    if (document.translation != glm::dvec3(0.0))
      node["translation"] = array_of(document.translation);
    if (document.scale != 1.0) node["scale"] = array_of(glm::dvec3(document.scale));
    to["scenes"][0]["nodes"].push_back(m);
  }
  std::map<std::string, std::size_t> known;
  for (const GltfArrays& arrays : document.primitives) {
    const std::string& name = arrays.material.empty() ? arrays.name : arrays.material;
    const auto found = document.shares_materials ? known.find(name) : known.end();
    const std::size_t material =
        found != known.end() ? found->second : add_material(name, options, to["materials"]);
    known.try_emplace(name, material);
    json& primitive =
        meshes[arrays.mesh]["primitives"].emplace_back(json{{"attributes", arrays.attributes},
                                                            {"indices", arrays.indices},
                                                            {"material", material},
                                                            {"mode", kTriangleMode}});
    // Primitives have no name of their own.
    if (!arrays.name.empty()) primitive["extras"] = {{"group", arrays.name}};
  }
}

void add_buffers(const GltfDocument& document, std::string_view uri, json& to) {
  json& buffers = to["buffers"] = json::array();
  for (const GltfBuffer& buffer : document.buffers)
    buffers.push_back({{"byteLength", buffer.bytes}, {"uri", buffer.uri}});
  if (!document.buffers.empty()) return;
  buffers.push_back({{"byteLength", document.buffer_bytes}});
  if (!uri.empty()) buffers[0]["uri"] = uri;
  if (document.decoded_bytes > 0)
    buffers.push_back({{"byteLength", document.decoded_bytes},
                       {"extensions", {{kMeshopt, {{"fallback", true}}}}}});
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

std::string gltf_json(const GltfDocument& document, const GltfOptions& options,
                      std::string_view buffer_uri) {
  json written{{"asset", asset_of(options)}, {"scene", 0}};
  add_meshes(document, options, written);
  if (!document.extensions.empty())
    written["extensionsUsed"] = written["extensionsRequired"] = document.extensions;
  add_arrays(document, written);
  add_buffers(document, buffer_uri, written);
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
