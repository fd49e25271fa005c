// Based on: Khronos Group, "glTF 2.0 Specification", 2021: what names accessors and buffer views.
#include "planish/files/gltf/asset/asset_references.h"

#include <algorithm>
#include <iterator>
#include <string>

#include "planish/core/json.h"
#include "planish/files/gltf/asset/geometry_extensions.h"
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

}  // namespace

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

}  // namespace planish
