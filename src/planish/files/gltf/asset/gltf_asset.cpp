#include "planish/files/gltf/asset/gltf_asset.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/files/gltf/gltf_json.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/mend/faults.h"

namespace planish {
namespace {

using nlohmann::json;

const json* found(const json& in, std::initializer_list<const char*> path) {
  const json* at = &in;
  for (const char* key : path) {
    const auto next = at->find(key);
    if (next == at->end()) return nullptr;
    at = &*next;
  }
  return at;
}

}  // namespace

json without_vertices(const json& primitive) {
  json rest = primitive;
  for (const char* key : {"attributes", "indices", "mode", "targets"}) rest.erase(key);
  if (const auto extensions = rest.find("extensions"); extensions != rest.end()) {
    if (extensions->is_object()) extensions->erase(kDracoExtension);
    if (extensions->empty()) rest.erase("extensions");
  }
  return rest;
}

std::int64_t primitive_number(std::string_view path) {
  std::int64_t number = 0;
  const std::string_view digits = path.substr(path.rfind('[') + 1);
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return number;
}

bool is_surface(const json& primitive) {
  constexpr int kTriangles = 4;
  if (!primitive.is_object()) return false;
  const auto mode = primitive.find("mode");
  const auto attributes = primitive.find("attributes");
  return attributes != primitive.end() && attributes->is_object() &&
         attributes->contains("POSITION") &&
         (mode == primitive.end() || (mode->is_number() && mode->get<double>() >= kTriangles));
}

int set_of_texture(const json& texture) {
  const json* moved = found(texture, {"extensions", "KHR_texture_transform", "texCoord"});
  return moved != nullptr ? moved->get<int>() : texture.value("texCoord", 0);
}

int tangent_set(const json& document, const json& primitive) {
  const auto number = primitive.find("material");
  if (number == primitive.end()) return -1;
  const json& material = document.at("materials").at(number->get<std::size_t>());
  const json* anisotropy = found(material, {"extensions", "KHR_materials_anisotropy"});
  for (const json* texture :
       {found(material, {"normalTexture"}),
        found(material, {"extensions", "KHR_materials_clearcoat", "clearcoatNormalTexture"}),
        anisotropy != nullptr ? found(*anisotropy, {"anisotropyTexture"}) : nullptr})
    if (texture != nullptr) return set_of_texture(*texture);
  return anisotropy != nullptr ? 0 : -1;
}

namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", 2021: what names accessors and buffer views;
// its registry of glTF 2.0 extensions, and 3D Tiles' EXT_mesh_features and EXT_structural_metadata.

void add_number(const json& value, std::set<std::int64_t>& to) {
  if (value.is_number()) to.insert(static_cast<std::int64_t>(value.get<double>()));
}

void add_numbers(const json& object, std::set<std::int64_t>& to) {
  if (!object.is_object()) return;
  for (const json& value : object) add_number(value, to);
}

bool names_an_accessor(const std::string& key) {
  return key == "input" || key == "output" || key == "inverseBindMatrices" || key == "indices" ||
         key == "accessor";
}

// Accessors and buffer views that a document names, by number.
struct AssetReferences {
  std::set<std::int64_t> accessors, views;

  void add_primitive(const json& primitive);
  // Whatever stands anywhere in `value` under the names that the format and its extensions have
  // for them; no primitives.
  void add_all(const json& value);
};

void AssetReferences::add_primitive(const json& primitive) {
  if (primitive.contains("attributes")) add_numbers(primitive["attributes"], accessors);
  if (primitive.contains("indices")) add_number(primitive["indices"], accessors);
  if (primitive.contains("targets"))
    for (const json& target : primitive["targets"]) add_numbers(target, accessors);
  if (!primitive.contains("extensions")) return;
  const json& extensions = primitive["extensions"];
  if (extensions.contains(kDracoExtension) && extensions[kDracoExtension].contains("bufferView"))
    add_number(extensions[kDracoExtension]["bufferView"], views);
}

void AssetReferences::add_all(const json& value) {
  if (!value.is_structured()) return;
  for (const auto& [key, member] : value.items()) {
    if (value.is_object() && key == "bufferView") {
      add_number(member, views);
    } else if (value.is_object() && names_an_accessor(key)) {
      add_number(member, accessors);
    } else if (value.is_object() && key == "attributes") {
      add_numbers(member, accessors);
    }
    add_all(member);
  }
}

// Of an accessor.
void add_views(const json& accessor, std::set<std::int64_t>& to) {
  if (accessor.contains("bufferView")) add_number(accessor["bufferView"], to);
  if (!accessor.contains("sparse")) return;
  for (const char* part : {"indices", "values"})
    if (accessor["sparse"].contains(part) && accessor["sparse"][part].contains("bufferView"))
      add_number(accessor["sparse"][part]["bufferView"], to);
}

std::set<std::int64_t> views_of(const json& document, const std::set<std::int64_t>& accessors) {
  std::set<std::int64_t> views;
  for (const std::int64_t number : accessors)
    if (document.contains("accessors") && number < std::ssize(document["accessors"]))
      add_views(document["accessors"][number], views);
  return views;
}

// What a mesh or a primitive has besides vertices; extensions that describe those go with them.
void add_besides(const json& holder, bool gives_way, AssetReferences& replaced,
                 AssetReferences& kept) {
  json rest = holder;
  if (gives_way && rest.contains("extensions") && rest["extensions"].is_object()) {
    for (const auto& [name, extension] : rest["extensions"].items())
      (describes_triangles(name, extension) ? replaced : kept).add_all(extension);
    rest.erase("extensions");
  }
  kept.add_all(rest);
}

// Whether the extension has anything left to say; takes out what is untrue, and says so.
using Rewrite = bool (*)(json& extension, const NewGeometry& made, bool& is_cut);

// Elements of a list for which `is_true` holds.
template <class IsTrue>
bool keep_true(json& extension, const char* list, bool& is_cut, const IsTrue& is_true) {
  if (!extension.contains(list)) return false;
  json kept = json::array();
  for (const json& one : extension[list])
    if (is_true(one)) kept.push_back(one);
  is_cut |= kept.size() < extension[list].size();
  extension[list] = kept;
  if (kept.empty()) extension.erase(list);
  return !kept.empty();
}

// A set of ids that is neither in an attribute nor in a texture numbers vertices in their order.
bool keep_features(json& extension, const NewGeometry&, bool& is_cut) {
  return keep_true(extension, "featureIds", is_cut, [](const json& ids) {
    return ids.contains("attribute") || ids.contains("texture");
  });
}

bool keep_ngons(json&, const NewGeometry& made, bool& is_cut) {
  is_cut |= !made.encodes_ngons;
  return made.encodes_ngons;
}

struct KnownExtension {
  std::string_view name;
  bool describes_triangles;  // and goes with them
  Rewrite rewrite;           // of those that stay; null: as they are
};

// All that is known of extensions of meshes and primitives. KHR_draco_mesh_compression is no part
// of what a primitive is besides its vertices.
constexpr std::array kKnownExtensions = {
    KnownExtension{"KHR_materials_variants", false, nullptr},
    KnownExtension{"EXT_mesh_features", false, keep_features},
    KnownExtension{"EXT_structural_metadata", false, nullptr},
    KnownExtension{kNgonExtension, false, keep_ngons},
    KnownExtension{"CESIUM_primitive_outline", true, nullptr},
    KnownExtension{"EXT_mesh_manifold", true, nullptr},
    KnownExtension{"EXT_mesh_primitive_edge_visibility", true, nullptr}};

const KnownExtension* known(const std::string& name) {
  const auto* const found = std::ranges::find(kKnownExtensions, name, &KnownExtension::name);
  return found == kKnownExtensions.end() ? nullptr : found;
}

void drop(json& holder, const std::string& name) {
  holder["extensions"].erase(name);
  if (holder["extensions"].empty()) holder.erase("extensions");
}

}  // namespace

FreePlaces free_places(const json& document, const std::set<std::int64_t>& replaced_meshes) {
  AssetReferences replaced, kept;
  for (const auto& [key, value] : document.items())
    if (key != "meshes" && key != "accessors" && key != "bufferViews") kept.add_all(value);
  if (document.contains("meshes")) {
    for (std::size_t m = 0; m < document["meshes"].size(); ++m) {
      const bool gives_way = replaced_meshes.contains(static_cast<std::int64_t>(m));
      json mesh = document["meshes"][m];
      mesh.erase("primitives");
      add_besides(mesh, gives_way, replaced, kept);
      for (const json& primitive : document["meshes"][m]["primitives"]) {
        const bool is_replaced = gives_way && is_surface(primitive);
        (is_replaced ? replaced : kept).add_primitive(primitive);
        add_besides(without_vertices(primitive), is_replaced, replaced, kept);
      }
    }
  }
  FreePlaces free;
  std::ranges::set_difference(replaced.accessors, kept.accessors,
                              std::inserter(free.accessors, free.accessors.end()));
  std::set<std::int64_t> used = views_of(document, replaced.accessors);
  used.merge(replaced.views);
  // Accessors that nothing names keep their views too.
  std::set<std::int64_t> others;
  const std::size_t count = document.contains("accessors") ? document["accessors"].size() : 0;
  for (std::size_t i = 0; i < count; ++i)
    if (!free.accessors.contains(static_cast<std::int64_t>(i)))
      others.insert(static_cast<std::int64_t>(i));
  kept.views.merge(views_of(document, others));
  std::ranges::set_difference(used, kept.views, std::inserter(free.views, free.views.end()));
  return free;
}

bool describes_triangles(const std::string& name, const json& extension) {
  if (const KnownExtension* one = known(name)) return one->describes_triangles;
  AssetReferences named;
  named.add_all(extension);
  return !named.accessors.empty() || !named.views.empty();
}

void drop_untrue_extensions(json& holder, const NewGeometry& made, LostExtensions& lost) {
  if (!holder.contains("extensions") || !holder["extensions"].is_object()) return;
  const json given = holder["extensions"];
  for (const auto& [name, extension] : given.items()) {
    const KnownExtension* const one = known(name);
    bool is_cut = describes_triangles(name, extension), stays = !is_cut;
    if (stays && one != nullptr && one->rewrite != nullptr)
      stays = one->rewrite(holder["extensions"][name], made, is_cut);
    if (!stays) drop(holder, name);
    if (is_cut) ++lost[name];
  }
}

void drop_untrue_scenes(json& document, LostExtensions& lost) {
  if (!document.contains("scenes")) return;
  for (json& scene : document["scenes"]) {
    if (!scene.contains("extensions") || !scene["extensions"].contains(kCountsExtension)) continue;
    drop(scene, kCountsExtension);
    ++lost[kCountsExtension];
  }
}

std::string names_of(const LostExtensions& lost) {
  std::string names;
  for (const auto& [name, count] : lost)
    names += (names.empty() ? "" : ", ") + name + (count > 1 ? formatted(" ({})", count) : "");
  return names;
}

bool has_extension(const json& document, const std::string& name) {
  if (!document.is_structured()) return false;
  if (document.is_object() && document.contains("extensions") &&
      document["extensions"].is_object() && document["extensions"].contains(name))
    return true;
  return std::ranges::any_of(document,
                             [&](const json& member) { return has_extension(member, name); });
}

namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.5 to 3.11.

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

// Throws Error{UnreadableInput}, naming the place, where a part of the file names another that is
// not there (materials textures, textures images and samplers, nodes meshes, skins, cameras and
// children, skins joints, animations nodes), and where nodes do not form trees.
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

void copy_elements(std::vector<glm::dvec2>& values, std::span<const std::int32_t> copied) {
  for (const std::int32_t from : copied) values.push_back(values[from]);
}

// In every set of texture coordinates, with all that goes by their indices.
void cut_mirrored(PolygonMesh& mesh, AssetVertices& vertices) {
  for (std::size_t set = 0; set <= vertices.further_uvs.size(); ++set) {
    const std::vector<std::int32_t> copied =
        cut_mirrored_charts(mesh, set == 0 ? mesh.uvs : vertices.further_uvs[set - 1]);
    for (std::vector<glm::dvec2>& further : vertices.further_uvs) copy_elements(further, copied);
    for (AssetUvMoves& moves : vertices.uv_moves) copy_elements(moves.values, copied);
    for (AssetArray& array : vertices.arrays)
      if (array.of_corners)
        for (const std::int32_t from : copied)
          for (int k = 0; k < array.width; ++k)
            array.values.push_back(array.values[static_cast<std::size_t>(array.width * from + k)]);
  }
}

}  // namespace

GltfAsset::GltfAsset(const FileBytes& file, const GltfLimits& limits)
    : file_(file),
      limits_(limits),
      format_(split_glb(file.bytes, file.name).format),
      document_(std::make_shared<nlohmann::json>(
          parse_json(split_glb(file.bytes, file.name).json, file.name))),
      root_(*document_, file_.name, ""),
      source_(root_, split_glb(file.bytes, file.name).chunk, file) {
  file_.progress = nullptr;  // which counts the bytes of a scene
  require_gltf_version(root_);
  require_sound_asset(root_);
  const auto meshes = root_.find("meshes");
  for (std::int64_t i = 0; meshes && i < meshes->array_size(); ++i) {
    const JsonPlace primitives = (*meshes)[i]["primitives"];
    bool has_triangles = false;
    for (std::int64_t k = 0; k < primitives.array_size(); ++k)
      has_triangles |= is_surface(primitives[k].value());
    if (has_triangles) surfaces_.push_back(i);
  }
}

std::int64_t GltfAsset::corner_count(std::int64_t number) const {
  const JsonPlace primitives = root_["meshes"][number]["primitives"];
  std::int64_t count = 0;
  for (std::int64_t i = 0; i < primitives.array_size(); ++i) {
    const JsonPlace primitive = primitives[i];
    if (!is_surface(primitive.value())) continue;
    const auto indices = primitive.find("indices");
    const JsonPlace accessor = indices ? *indices : primitive["attributes"]["POSITION"];
    count += root_["accessors"][accessor.integer()]["count"].integer();
  }
  return count;
}

std::uint64_t GltfAsset::byte_count() const {
  std::uint64_t bytes = file_.bytes.size();
  const auto add_lengths = [&](std::string_view list, std::string_view having) {
    const auto all = root_.find(list);
    for (std::int64_t i = 0; all && i < all->array_size(); ++i)
      if ((*all)[i].find(having))
        bytes += static_cast<std::uint64_t>((*all)[i]["byteLength"].integer());
  };
  add_lengths("buffers", "uri");
  add_lengths("bufferViews", "extensions");
  const auto images = root_.find("images");
  for (std::int64_t i = 0; images && i < images->array_size(); ++i) {
    const auto uri = (*images)[i].find("uri");
    if (!uri || file_.path.empty()) continue;
    std::error_code error;
    if (const auto name = decode_uri_path(uri->text())) {
      const auto size =
          std::filesystem::file_size(file_.path.parent_path() / path_of(*name), error);
      if (!error) bytes += size;
    }
  }
  return bytes;
}

namespace {

// Empty where it has none.
std::string name_at(const JsonPlace& place) {
  const auto name = place.find("name");
  return name && name->is_text() ? std::string(name->text()) : std::string();
}

}  // namespace

AssetMesh GltfAsset::read(std::int64_t number, bool wants_tangents,
                          std::optional<bool> splits_normals) const {
  return guard_json(file_.name,
                    [&] { return read_unguarded(number, wants_tangents, splits_normals); });
}

AssetMesh GltfAsset::read_unguarded(std::int64_t number, bool wants_tangents,
                                    std::optional<bool> splits_normals) const {
  const JsonPlace place = root_["meshes"][number];
  AssetMesh mesh{.number = number, .name = place.path(), .file = {}, .vertices = {}};
  if (const std::string name = name_at(place); !name.empty()) mesh.name = visible(name);
  FileBytes file = file_;
  file.split_normals_crease = splits_normals.value_or(file.split_normals_crease);
  AssetCollector collector;
  mesh.file = SceneReader(root_, source_, GltfBudget(limits_, file_.name), file)
                  .read_mesh(format_, number, collector);
  mesh.vertices = collector.finish(mesh.file.mesh);
  const std::vector<Warning>& warnings = mesh.vertices.warnings;
  mesh.file.warnings.insert(mesh.file.warnings.end(), warnings.begin(), warnings.end());
  mesh.file.stands_alone = !mesh.vertices.moves() && !mesh.vertices.rides_on_uvs();
  require_joints(number, mesh.vertices);
  const auto set_of = [&](std::int64_t primitive) {
    return tangent_set(root_.value(), place["primitives"][primitive].value());
  };
  for (AssetGroup& group : mesh.vertices.groups) {
    int set = set_of(group.primitive);
    if (set < 0 && wants_tangents) set = 0;
    if (set < group.uv_sets) group.tangent_set = set;
    for (AssetLayer& layer : group.layers) {
      const int own = set_of(layer.primitive);
      if (own >= 0 && own < layer.uv_sets) layer.tangent_set = layer.first_uv_set + own;
    }
  }
  cut_mirrored(mesh.file.mesh, mesh.vertices);
  return mesh;
}

void GltfAsset::require_joints(std::int64_t number, const AssetVertices& vertices) const {
  if (vertices.influences.empty()) return;
  const std::int64_t last = std::ranges::max(vertices.influences, {}, &JointWeight::joint).joint;
  const auto nodes = root_.find("nodes");
  for (std::int64_t i = 0; nodes && i < nodes->array_size(); ++i) {
    const auto mesh = (*nodes)[i].find("mesh"), skin = (*nodes)[i].find("skin");
    if (!mesh || !skin || mesh->integer() != number) continue;
    const std::int64_t joints = root_["skins"][skin->integer()]["joints"].array_size();
    if (last >= joints)
      skin->fail(
          "its mesh names joint {}, and the skin has {}; take the skin that the mesh was made for",
          last, joints);
  }
}

AssetNames names_of(const GltfAsset& asset) {
  const JsonPlace& root = asset.root();
  const auto add = [](std::vector<AssetName>& names, const std::string& name, std::int64_t mesh) {
    if (name.empty()) return;
    auto found = std::ranges::find(names, name, &AssetName::name);
    if (found == names.end()) found = names.insert(names.end(), {name, {}});
    if (std::ranges::find(found->meshes, mesh) == found->meshes.end())
      found->meshes.push_back(mesh);
  };
  AssetNames names;
  for (const std::int64_t mesh : asset.surfaces()) {
    const JsonPlace place = root["meshes"][mesh];
    const std::string name = name_at(place);
    add(names.meshes, name.empty() ? place.path() : name, mesh);
    const JsonPlace primitives = place["primitives"];
    for (std::int64_t i = 0; i < primitives.array_size(); ++i)
      if (const auto material = primitives[i].find("material");
          material && is_surface(primitives[i].value()))
        add(names.materials, name_at(root["materials"][material->integer()]), mesh);
  }
  const auto nodes = root.find("nodes");
  const std::int64_t count = nodes ? nodes->array_size() : 0;
  for (std::int64_t top = 0; top < count; ++top) {
    std::vector<std::int64_t> below{top};
    std::set<std::int64_t> seen{top};
    while (!below.empty()) {
      const JsonPlace node = (*nodes)[below.back()];
      below.pop_back();
      if (const auto mesh = node.find("mesh");
          mesh && std::ranges::find(asset.surfaces(), mesh->integer()) != asset.surfaces().end())
        add(names.nodes, name_at((*nodes)[top]), mesh->integer());
      const auto children = node.find("children");
      for (std::int64_t i = 0; children && i < children->array_size(); ++i)
        if (seen.insert((*children)[i].integer()).second) below.push_back((*children)[i].integer());
    }
  }
  return names;
}

bool GltfAsset::may_be_scaled(std::int64_t number) const {
  const JsonPlace primitives = root_["meshes"][number]["primitives"];
  for (std::int64_t i = 0; i < primitives.array_size(); ++i)
    if (primitives[i].find("targets") || !is_surface(primitives[i].value())) return false;
  const auto nodes = root_.find("nodes");
  for (std::int64_t i = 0; nodes && i < nodes->array_size(); ++i) {
    const JsonPlace node = (*nodes)[i];
    const auto mesh = node.find("mesh");
    // Nobody knows what extensions do with the node's mesh.
    if (mesh && mesh->integer() == number && (node.find("skin") || node.find("extensions")))
      return false;
  }
  return true;
}

std::unique_ptr<const GltfAsset> asset_of(const FileBytes& file, FileFormat format) {
  if (!info_of(format).is_gltf) return nullptr;
  auto asset = std::make_unique<const GltfAsset>(file);
  return asset->surfaces().empty() ? nullptr : std::move(asset);
}

namespace {

bool has_tangents(const json& document, const json& primitive) {
  const int set = tangent_set(document, primitive);
  return set >= 0 && primitive["attributes"].contains(uv_name(set));
}

bool is_carried(const json& document, const json& primitive, const std::string& name) {
  return name != "TANGENT" || has_tangents(document, primitive);
}

// Of a mesh or a primitive, the extensions that go with its triangles.
void add_untrue(const json& holder, std::set<std::string>& names) {
  if (!holder.contains("extensions") || !holder["extensions"].is_object()) return;
  for (const auto& [name, extension] : holder["extensions"].items())
    if (describes_triangles(name, extension)) names.insert(name);
}

AssetContents counted_contents(const GltfAsset& asset) {
  const json& document = asset.root().value();
  AssetContents contents;
  for (const char* list : {"scenes", "nodes", "meshes", "materials", "textures", "images", "skins",
                           "animations", "cameras"})
    if (document.contains(list) && !document[list].empty())
      contents.counts.emplace_back(list, std::ssize(document[list]));
  std::set<std::string> carried, left_out;
  if (document.contains("scenes") && has_extension(document["scenes"], kCountsExtension))
    left_out.insert(kCountsExtension);
  for (const std::int64_t number : asset.surfaces()) {
    const json& primitives = document["meshes"][number]["primitives"];
    add_untrue(document["meshes"][number], left_out);
    for (const json& primitive : primitives) {
      if (!is_surface(primitive)) continue;
      add_untrue(without_vertices(primitive), left_out);
      for (const auto& [name, accessor] : primitive["attributes"].items())
        (is_carried(document, primitive, name) ? carried : left_out).insert(name);
      if (has_tangents(document, primitive)) carried.insert("TANGENT");
    }
    if (primitives[0].contains("targets"))
      contents.morph_targets += std::ssize(primitives[0]["targets"]);
  }
  contents.carried.assign(carried.begin(), carried.end());
  contents.left_out.assign(left_out.begin(), left_out.end());
  if (document.contains("extensionsUsed"))
    for (const json& name : document["extensionsUsed"])
      if (name != kMeshoptExtension && name != kDracoExtension && name != "KHR_mesh_quantization" &&
          !left_out.contains(name.get<std::string>()))
        contents.extensions.push_back(name.get<std::string>());
  return contents;
}

}  // namespace

AssetContents contents_of(const GltfAsset& asset) {
  return guard_json(asset.file().name, [&] { return counted_contents(asset); });
}

}  // namespace planish
