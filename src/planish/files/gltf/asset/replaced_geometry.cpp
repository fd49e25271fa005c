// Based on: Khronos Group, "glTF 2.0 Specification", 2021: what names accessors and buffer views;
// its registry of glTF 2.0 extensions, and 3D Tiles' EXT_mesh_features and EXT_structural_metadata.
#include "planish/files/gltf/asset/replaced_geometry.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>

#include "planish/core/formatted.h"
#include "planish/core/json.h"
#include "planish/files/gltf/asset/primitive_parts.h"
#include "planish/files/gltf/draco_stream.h"

namespace planish {
namespace {

using nlohmann::json;

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

}  // namespace planish
