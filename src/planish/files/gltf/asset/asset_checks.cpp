// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.5 to 3.11.
#include "planish/files/gltf/asset/asset_checks.h"

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "planish/files/gltf/scene_reader.h"

namespace planish {
namespace {

// Extensions that leave alone what a mesh is, besides those that any reading takes.
constexpr std::array<std::string_view, 7> kPassing = {
    "KHR_animation_pointer", "KHR_node_",   "KHR_xmp_json_ld", "MSFT_lod",
    "KHR_interactivity",     "KHR_lights_", "MSFT_texture_dds"};

std::int64_t count_of(const JsonPlace& root, std::string_view key) {
  const auto array = root.find(key);
  return array ? array->array_size() : 0;
}

// What `place` has under `key` is the number of an element of root's `array`.
void require_number(const JsonPlace& root, const JsonPlace& place, std::string_view key,
                    std::string_view array) {
  const auto number = place.find(key);
  if (!number) return;
  const std::int64_t count = count_of(root, array);
  if (number->integer() >= count)
    number->fail("names " + std::string(array) + "[" + std::to_string(number->integer()) +
                 "], and the file has " + std::to_string(count) +
                 "; save it anew with the program that wrote it");
}

// Calls visit(element) for each of root's `array`.
template <class Visit>
void for_each(const JsonPlace& root, std::string_view array, const Visit& visit) {
  const auto all = root.find(array);
  for (std::int64_t i = 0; all && i < all->array_size(); ++i) visit((*all)[i]);
}

// Whatever a material or an extension of it calls a texture.
void require_textures(const JsonPlace& root, const JsonPlace& place) {
  for (const std::string& key : place.keys()) {
    const JsonPlace member = place[key];
    if (!member.is_object() || key == "extras") continue;
    if (key.ends_with("Texture")) require_number(root, member, "index", "textures");
    require_textures(root, member);
  }
}

void require_trees(const JsonPlace& root) {
  const auto count = static_cast<std::size_t>(count_of(root, "nodes"));
  std::vector<std::int64_t> parents(count, -1);
  std::int64_t number = 0;
  for_each(root, "nodes", [&](const JsonPlace& node) {
    const auto children = node.find("children");
    for (std::int64_t i = 0; children && i < children->array_size(); ++i) {
      const JsonPlace child = (*children)[i];
      if (child.integer() >= std::ssize(parents))
        child.fail("names nodes[" + std::to_string(child.integer()) + "], and the file has " +
                   std::to_string(count));
      std::int64_t& parent = parents[static_cast<std::size_t>(child.integer())];
      if (parent >= 0)
        child.fail("node " + std::to_string(child.integer()) + " is a child of node " +
                   std::to_string(parent) + " already, but nodes must form trees");
      parent = number;
    }
    ++number;
  });
  // Every way up must end; a node that was seen to is not walked again.
  std::vector<bool> is_known(count, false);
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<std::size_t> way;
    auto at = static_cast<std::int64_t>(i);
    for (; at >= 0 && !is_known[static_cast<std::size_t>(at)];
         at = parents[static_cast<std::size_t>(at)]) {
      if (way.size() > count)
        root["nodes"][at].fail("is its own ancestor, but nodes must form trees");
      way.push_back(static_cast<std::size_t>(at));
    }
    for (const std::size_t node : way) is_known[node] = true;
  }
}

void require_skin(const JsonPlace& root, const JsonPlace& skin) {
  const JsonPlace joints = skin["joints"];
  if (joints.array_size() == 0) joints.fail("a skin needs a joint; remove the skin");
  for (std::int64_t i = 0; i < joints.array_size(); ++i)
    if (joints[i].integer() >= count_of(root, "nodes"))
      joints[i].fail("names nodes[" + std::to_string(joints[i].integer()) + "], and the file has " +
                     std::to_string(count_of(root, "nodes")));
  require_number(root, skin, "skeleton", "nodes");
  require_number(root, skin, "inverseBindMatrices", "accessors");
}

void require_animation(const JsonPlace& root, const JsonPlace& animation) {
  const JsonPlace samplers = animation["samplers"], channels = animation["channels"];
  for (std::int64_t i = 0; i < samplers.array_size(); ++i) {
    require_number(root, samplers[i], "input", "accessors");
    require_number(root, samplers[i], "output", "accessors");
  }
  for (std::int64_t i = 0; i < channels.array_size(); ++i) {
    if (channels[i]["sampler"].integer() >= samplers.array_size())
      channels[i]["sampler"].fail("is asked for, and there are " +
                                  std::to_string(samplers.array_size()));
    require_number(root, channels[i]["target"], "node", "nodes");
  }
}

}  // namespace

void require_asset_version(const JsonPlace& root) { require_gltf_version(root, kPassing); }

void require_sound_asset(const JsonPlace& root) {
  for_each(root, "materials", [&](const JsonPlace& material) { require_textures(root, material); });
  for_each(root, "textures", [&](const JsonPlace& texture) {
    require_number(root, texture, "source", "images");
    require_number(root, texture, "sampler", "samplers");
  });
  for_each(root, "images", [&](const JsonPlace& image) {
    require_number(root, image, "bufferView", "bufferViews");
  });
  for_each(root, "accessors", [&](const JsonPlace& accessor) {
    require_number(root, accessor, "bufferView", "bufferViews");
  });
  for_each(root, "nodes", [&](const JsonPlace& node) {
    require_number(root, node, "mesh", "meshes");
    require_number(root, node, "skin", "skins");
    require_number(root, node, "camera", "cameras");
  });
  require_trees(root);
  for_each(root, "skins", [&](const JsonPlace& skin) { require_skin(root, skin); });
  for_each(root, "animations",
           [&](const JsonPlace& animation) { require_animation(root, animation); });
  for_each(root, "meshes", [&](const JsonPlace& mesh) {
    const JsonPlace primitives = mesh["primitives"];
    for (std::int64_t i = 0; i < primitives.array_size(); ++i)
      require_number(root, primitives[i], "material", "materials");
  });
}

}  // namespace planish
