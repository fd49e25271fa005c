// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.5 to 3.11.
#include "planish/files/gltf/asset/asset_checks.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/formatted.h"
#include "planish/core/json.h"
#include "planish/core/number_text.h"
#include "planish/files/gltf/gltf_nodes.h"

namespace planish {
namespace {

std::int64_t count_of(const JsonPlace& root, std::string_view key) {
  const auto array = root.find(key);
  return array ? array->array_size() : 0;
}

constexpr std::string_view kRemedy = "; save it anew with the program that wrote it";

// `number` is that of one of `count` elements of `array`.
void require_below(const JsonPlace& number, std::int64_t count, std::string_view array) {
  if (number.integer() < count) return;
  number.fail("names {}[{}], and the file has {}{}", array, number.integer(), count, kRemedy);
}

// What `place` has under `key`, where it is there, is the number of an element of root's `array`.
void require_number(const JsonPlace& root, const JsonPlace& place, std::string_view key,
                    std::string_view array) {
  if (const auto number = place.find(key)) require_below(*number, count_of(root, array), array);
}

// The same of the numbers that a list there has.
void require_numbers(const JsonPlace& root, const JsonPlace& place, std::string_view key,
                     std::string_view array) {
  const auto list = place.find(key);
  for (std::int64_t i = 0; list && i < list->array_size(); ++i)
    require_below((*list)[i], count_of(root, array), array);
}

// The same of all members of an object there.
void require_members(const JsonPlace& root, const JsonPlace& place, std::string_view key,
                     std::string_view array) {
  const auto object = place.find(key);
  if (!object) return;
  for (const std::string& name : object->keys())
    require_below((*object)[name], count_of(root, array), array);
}

std::optional<JsonPlace> extension_of(const JsonPlace& place, std::string_view name) {
  const auto all = place.find("extensions");
  return all ? all->find(name) : std::nullopt;
}

// Of an element; 0 where the format does not say.
std::int64_t element_bytes(const JsonPlace& accessor) {
  constexpr std::array<std::pair<std::string_view, std::array<std::int64_t, 2>>, 7> kTypes{
      {{"SCALAR", {1, 1}},
       {"VEC2", {1, 2}},
       {"VEC3", {1, 3}},
       {"VEC4", {1, 4}},
       {"MAT2", {2, 2}},
       {"MAT3", {3, 3}},
       {"MAT4", {4, 4}}}};
  const std::int64_t component = accessor["componentType"].integer();
  const std::int64_t bytes = component == 5120 || component == 5121   ? 1
                             : component == 5122 || component == 5123 ? 2
                             : component == 5125 || component == 5126 ? 4
                                                                      : 0;
  for (const auto& [type, size] : kTypes) {
    if (accessor["type"].text() != type) continue;
    const std::int64_t column = bytes * size[1];
    // Columns of matrices begin at multiples of four.
    return size[0] == 1 ? column : size[0] * ((column + 3) / 4 * 4);
  }
  return 0;
}

// All of an accessor lies in its view. Of what is read that is seen then; the rest only passes.
void require_room(const JsonPlace& root, const JsonPlace& accessor) {
  require_number(root, accessor, "bufferView", "bufferViews");
  const auto number = accessor.find("bufferView");
  const std::int64_t bytes = number ? element_bytes(accessor) : 0;
  if (bytes == 0) return;
  const JsonPlace view = root["bufferViews"][number->integer()];
  const std::int64_t count = accessor["count"].integer(1);
  const std::int64_t stride = view.integer_or("byteStride", bytes);
  const std::int64_t offset = accessor.integer_or("byteOffset", 0);
  const std::int64_t length = view["byteLength"].integer();
  // Without sums that could overflow.
  if (offset <= length - bytes &&
      (count == 1 || count - 1 <= (length - bytes - offset) / std::max<std::int64_t>(stride, 1)))
    return;
  accessor.fail("{} elements of {} bytes reach beyond {}, which has {}{}", count, bytes,
                view.path(), length, kRemedy);
}

std::int64_t accessor_count(const JsonPlace& root, const JsonPlace& number) {
  return root["accessors"][number.integer()]["count"].integer(1);
}

// Of a mesh, by its first primitive: another number in others is refused where they are read.
std::int64_t target_count(const JsonPlace& mesh) {
  const JsonPlace primitives = mesh["primitives"];
  if (primitives.array_size() == 0) return 0;
  const auto targets = primitives[0].find("targets");
  return targets ? targets->array_size() : 0;
}

// Weights that a mesh, or a node of it, has for its targets.
void require_weights(const JsonPlace& place, std::int64_t targets) {
  const auto weights = place.find("weights");
  if (!weights || weights->array_size() == targets) return;
  weights->fail("{} for {} morph targets; each needs one{}", weights->array_size(), targets,
                kRemedy);
}

void require_primitive(const JsonPlace& root, const JsonPlace& primitive) {
  require_number(root, primitive, "material", "materials");
  require_number(root, primitive, "indices", "accessors");
  require_members(root, primitive, "attributes", "accessors");
  const auto targets = primitive.find("targets");
  for (std::int64_t i = 0; targets && i < targets->array_size(); ++i) {
    const JsonPlace target = (*targets)[i];
    for (const std::string& name : target.keys()) {
      require_below(target[name], count_of(root, "accessors"), "accessors");
      const auto given = primitive["attributes"].find(name);
      if (given && accessor_count(root, *given) != accessor_count(root, target[name]))
        target[name].fail("{} moves for {} vertices{}", accessor_count(root, target[name]),
                          accessor_count(root, *given), kRemedy);
    }
  }
  const auto variants = extension_of(primitive, "KHR_materials_variants");
  const auto mappings = variants ? variants->find("mappings") : std::nullopt;
  for (std::int64_t i = 0; mappings && i < mappings->array_size(); ++i)
    require_number(root, (*mappings)[i], "material", "materials");
}

// Attributes of places are as many of each, and of the types that readers place meshes by.
void require_instances(const JsonPlace& root, const JsonPlace& instances) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kTypes{
      {{"ROTATION", "VEC4"}, {"SCALE", "VEC3"}, {"TRANSLATION", "VEC3"}}};
  require_members(root, instances, "attributes", "accessors");
  const auto attributes = instances.find("attributes");
  std::int64_t count = -1;
  for (const std::string& name : attributes ? attributes->keys() : std::vector<std::string>{}) {
    const JsonPlace accessor = (*attributes)[name];
    const std::int64_t found = accessor_count(root, accessor);
    if (count < 0) count = found;
    for (const auto& [attribute, type] : kTypes)
      if (name == attribute && root["accessors"][accessor.integer()]["type"].text() != type)
        accessor.fail("is no {}, as each place needs one{}", type, kRemedy);
    if (found != count)
      accessor.fail("{} values, and another attribute has {}; each place needs one{}", found, count,
                    kRemedy);
  }
}

void require_node(const JsonPlace& root, const JsonPlace& node) {
  require_number(root, node, "mesh", "meshes");
  require_number(root, node, "skin", "skins");
  require_number(root, node, "camera", "cameras");
  (void)local_transform(node);
  if (const auto mesh = node.find("mesh"))
    require_weights(node, target_count(root["meshes"][mesh->integer()]));
  if (const auto lod = extension_of(node, "MSFT_lod")) require_numbers(root, *lod, "ids", "nodes");
  if (const auto light = extension_of(node, "KHR_lights_punctual")) {
    const auto lights = extension_of(root, "KHR_lights_punctual");
    if (const auto number = light->find("light"))
      require_below(*number, lights ? count_of(*lights, "lights") : 0, "lights");
  }
  if (const auto instances = extension_of(node, "EXT_mesh_gpu_instancing"))
    require_instances(root, *instances);
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
      require_below(child, std::ssize(parents), "nodes");
      std::int64_t& parent = parents[child.integer()];
      if (parent >= 0)
        child.fail("node {} is a child of node {} already, but nodes must form trees{}",
                   child.integer(), parent, kRemedy);
      parent = number;
    }
    ++number;
  });
  // Every way up must end; a node that was seen to is not walked again.
  std::vector<bool> is_known(count, false);
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<std::size_t> way;
    auto at = static_cast<std::int64_t>(i);
    for (; at >= 0 && !is_known[at]; at = parents[at]) {
      if (way.size() > count)
        root["nodes"][at].fail("is its own ancestor, but nodes must form trees" +
                               std::string(kRemedy));
      way.push_back(static_cast<std::size_t>(at));
    }
    for (const std::size_t node : way) is_known[node] = true;
  }
}

void require_skin(const JsonPlace& root, const JsonPlace& skin) {
  const JsonPlace joints = skin["joints"];
  if (joints.array_size() == 0) joints.fail("a skin needs a joint; remove the skin");
  require_numbers(root, skin, "joints", "nodes");
  require_number(root, skin, "skeleton", "nodes");
  require_number(root, skin, "inverseBindMatrices", "accessors");
  const auto matrices = skin.find("inverseBindMatrices");
  if (matrices && accessor_count(root, *matrices) < joints.array_size())
    matrices->fail("{} matrices for {} joints{}", accessor_count(root, *matrices),
                   joints.array_size(), kRemedy);
}

// As many values as keys, with those of tangents and of all targets.
void require_keys(const JsonPlace& root, const JsonPlace& sampler, const JsonPlace& target) {
  const auto path = target.find("path");
  if (!path || path->text() == "pointer") return;
  std::int64_t values = 1;
  const auto node = target.find("node");
  if (path->text() == "weights") {
    const auto mesh = node ? root["nodes"][node->integer()].find("mesh") : std::nullopt;
    if (!mesh) return;
    values = target_count(root["meshes"][mesh->integer()]);
  }
  const auto way = sampler.find("interpolation");
  if (way && way->text() == "CUBICSPLINE") values *= 3;
  const std::int64_t keys = accessor_count(root, sampler["input"]);
  const std::int64_t found = accessor_count(root, sampler["output"]);
  if (values == 0 || (found % values == 0 && found / values == keys)) return;
  sampler["output"].fail("{} values for {} key frames of {}{}", found, keys, values, kRemedy);
}

// What an animation moves by its place in the document, as far as that is lists: of objects the
// member may be one that has a default.
void require_pointer(const JsonPlace& root, const JsonPlace& pointer) {
  const auto fail = [&](const std::string& what) {
    pointer.fail(quote(pointer.text()) + " names nothing: " + what + std::string(kRemedy));
  };
  std::string_view rest = pointer.text();
  if (!rest.starts_with('/')) fail("it begins with no /");
  std::optional<JsonPlace> at = root;
  while (at && !rest.empty()) {
    rest.remove_prefix(1);
    const std::string key(rest.substr(0, rest.find('/')));
    rest.remove_prefix(key.size());
    if (at->is_object()) {
      const bool is_root = at->path() == root.path();
      at = at->find(key);
      if (!at && is_root) fail("the file has no " + key);
      continue;
    }
    std::int64_t number = -1;
    if (!at->value().is_array() || !parse_integer(key, number)) return;
    if (number < 0 || number >= at->array_size())
      fail(formatted("the file has {} of {}", at->array_size(), at->path()));
    at = (*at)[number];
  }
}

void require_animation(const JsonPlace& root, const JsonPlace& animation) {
  const JsonPlace samplers = animation["samplers"], channels = animation["channels"];
  for (std::int64_t i = 0; i < samplers.array_size(); ++i) {
    require_number(root, samplers[i], "input", "accessors");
    require_number(root, samplers[i], "output", "accessors");
  }
  for (std::int64_t i = 0; i < channels.array_size(); ++i) {
    if (channels[i]["sampler"].integer() >= samplers.array_size())
      channels[i]["sampler"].fail("names samplers[{}], and the animation has {}{}",
                                  channels[i]["sampler"].integer(), samplers.array_size(), kRemedy);
    require_number(root, channels[i]["target"], "node", "nodes");
    require_keys(root, samplers[channels[i]["sampler"].integer()], channels[i]["target"]);
    if (const auto pointer = extension_of(channels[i]["target"], "KHR_animation_pointer"))
      require_pointer(root, (*pointer)["pointer"]);
  }
}

}  // namespace

void require_sound_asset(const JsonPlace& root) {
  for_each(root, "materials", [&](const JsonPlace& material) { require_textures(root, material); });
  for_each(root, "textures", [&](const JsonPlace& texture) {
    require_number(root, texture, "source", "images");
    require_number(root, texture, "sampler", "samplers");
  });
  for_each(root, "images", [&](const JsonPlace& image) {
    require_number(root, image, "bufferView", "bufferViews");
  });
  for_each(root, "bufferViews",
           [&](const JsonPlace& view) { require_number(root, view, "buffer", "buffers"); });
  for_each(root, "accessors", [&](const JsonPlace& accessor) { require_room(root, accessor); });
  for_each(root, "meshes", [&](const JsonPlace& mesh) {
    const JsonPlace primitives = mesh["primitives"];
    for (std::int64_t i = 0; i < primitives.array_size(); ++i)
      require_primitive(root, primitives[i]);
    require_weights(mesh, target_count(mesh));
  });
  for_each(root, "nodes", [&](const JsonPlace& node) { require_node(root, node); });
  require_number(root, root, "scene", "scenes");
  for_each(root, "scenes",
           [&](const JsonPlace& scene) { require_numbers(root, scene, "nodes", "nodes"); });
  require_trees(root);
  for_each(root, "skins", [&](const JsonPlace& skin) { require_skin(root, skin); });
  for_each(root, "animations",
           [&](const JsonPlace& animation) { require_animation(root, animation); });
}

}  // namespace planish
