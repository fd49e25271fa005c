#include "planish/files/gltf/asset/mesh_levels.h"

#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/json.h"

namespace planish {
namespace {

using nlohmann::json;

constexpr const char* kInstances = "EXT_mesh_gpu_instancing";
constexpr const char* kPointer = "KHR_animation_pointer";

json vector_of(const glm::dvec3& v) { return json::array({v.x, v.y, v.z}); }

void place(json& node, const MeshLevel& level) {
  node["mesh"] = level.mesh;
  if (!level.is_placed()) return;
  node["scale"] = vector_of(glm::dvec3(level.scale));
  node["translation"] = vector_of(level.translation);
}

// What of a node belongs to its mesh.
json mesh_part(const json& node) {
  json part = json::object();
  for (const char* const key : {"skin", "weights"})
    if (node.contains(key)) part[key] = node[key];
  if (node.contains("extensions") && node["extensions"].contains(kInstances))
    part["extensions"][kInstances] = node["extensions"][kInstances];
  return part;
}

void drop_mesh_part(json& node) {
  for (const char* const key : {"mesh", "weights"}) node.erase(key);
  if (!node.contains("extensions")) return;
  node["extensions"].erase(kInstances);
  if (node["extensions"].empty()) node.erase("extensions");
}

// Whether a channel's target moves the weights of a node, by the format itself or by a pointer.
bool moves_weights(const json& target, std::size_t node) {
  if (target.value("path", "") == "weights")
    return target.contains("node") && target["node"] == node;
  if (!target.contains("extensions") || !target["extensions"].contains(kPointer)) return false;
  const std::string pointer = target["extensions"][kPointer].value("pointer", "");
  const std::string weights = formatted("/nodes/{}/weights", node);
  return pointer == weights || pointer.starts_with(weights + "/");
}

void aim_at(json& target, std::size_t from, std::size_t to) {
  if (target.contains("node")) target["node"] = to;
  if (!target.contains("extensions") || !target["extensions"].contains(kPointer)) return;
  json& pointer = target["extensions"][kPointer]["pointer"];
  const std::string text = pointer.get<std::string>();
  const std::string node = formatted("/nodes/{}", from);
  pointer = formatted("/nodes/{}{}", to, text.substr(node.size()));
}

// Channels of a node's weights move those of each that stands for it, with the same samplers.
void move_weights(json& document, std::size_t node, const std::vector<std::size_t>& stand_ins) {
  if (!document.contains("animations")) return;
  for (json& animation : document["animations"]) {
    json& channels = animation["channels"];
    const std::size_t count = channels.size();
    for (std::size_t c = 0; c < count; ++c) {
      if (!moves_weights(channels[c]["target"], node)) continue;
      const json given = channels[c];
      aim_at(channels[c]["target"], node, stand_ins.front());
      for (std::size_t k = 1; k < stand_ins.size(); ++k) {
        json further = given;
        aim_at(further["target"], node, stand_ins[k]);
        channels.push_back(further);
      }
    }
  }
}

void place_details(json& document, std::size_t number, std::span<const MeshLevel> levels) {
  json& nodes = document["nodes"];
  const json given = nodes[number];
  if (given.contains("extensions") && given["extensions"].contains(kLodExtension))
    throw Error(ErrorCode::InvalidArgument,
                formatted("nodes[{}] has levels of detail already (MSFT_lod); take a file for each "
                          "level (--lods files)",
                          number));
  const bool is_beside = given.contains("skin");
  std::vector<std::size_t> stand_ins;
  std::vector<std::size_t> coarser;
  std::vector<double> coverage;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    coverage.push_back(levels[k].least_coverage);
    if (k == 0 && is_beside) {
      stand_ins.push_back(number);
      continue;
    }
    json node = mesh_part(given);
    if (given.contains("name"))
      node["name"] = formatted("{}_LOD{}", given["name"].get<std::string>(), k);
    place(node, levels[k]);
    if (k > 0) coarser.push_back(nodes.size());
    stand_ins.push_back(nodes.size());
    nodes.push_back(std::move(node));
  }
  if (!is_beside) {
    drop_mesh_part(nodes[number]);
    nodes[number]["children"].push_back(stand_ins.front());
  }
  json& finest = nodes[stand_ins.front()];
  finest["extensions"][kLodExtension] = {{"ids", coarser}};
  if (!finest.contains("extras") || finest["extras"].is_object())
    finest["extras"]["MSFT_screencoverage"] = coverage;
  move_weights(document, number, stand_ins);
}

}  // namespace

void place_levels(json& document, std::span<const MeshLevel> levels) {
  if (!document.contains("nodes")) return;
  json& nodes = document["nodes"];
  const std::size_t count = nodes.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (!nodes[i].contains("mesh") || nodes[i]["mesh"] != levels.front().mesh) continue;
    if (levels.size() > 1) {
      place_details(document, i, levels);
    } else if (levels.front().is_placed()) {
      // A child between: the node's own children and animations stay where they are.
      nodes[i].erase("mesh");
      nodes[i]["children"].push_back(nodes.size());
      json child = json::object();
      place(child, levels.front());
      nodes.push_back(std::move(child));
    }
  }
}

}  // namespace planish
