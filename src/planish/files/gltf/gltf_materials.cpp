#include "planish/files/gltf/gltf_materials.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "planish/files/gltf/asset/image_type.h"
#include "planish/files/gltf/asset/json_guard.h"
#include "planish/files/gltf/asset/primitive_parts.h"
#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/gltf_source.h"

namespace planish {
namespace {

using nlohmann::json;

void add_extensions(const json& in, std::set<std::string>& names) {
  if (!in.is_structured()) return;
  if (in.is_object() && in.contains("extensions"))
    for (const auto& [name, value] : in["extensions"].items()) names.insert(name);
  for (const json& value : in) add_extensions(value, names);
}

// Members that name a texture and another set of texture coordinates than the first.
std::int64_t drop_further_sets(json& in) {
  if (!in.is_structured()) return 0;
  std::int64_t count = 0;
  std::vector<std::string> dropped;
  for (const auto& [key, value] : in.items()) {
    if (in.is_object() && value.is_object() && value.contains("index") &&
        set_of_texture(value) != 0) {
      dropped.push_back(key);
    } else {
      count += drop_further_sets(value);
    }
  }
  for (const std::string& key : dropped) in.erase(key);
  return count + std::ssize(dropped);
}

void add_names(const json& names, const char* list, json& document) {
  for (const json& name : names) {
    json& all = document[list];
    if (std::ranges::find(all, name) == all.end()) all.push_back(name);
  }
}

GltfMaterials made_of(const GltfAsset& asset) {
  const json& document = asset.root().value();
  GltfMaterials made;
  if (!document.contains("materials")) return made;
  for (const char* list : {"materials", "textures", "samplers", "images"})
    if (document.contains(list)) made.lists[list] = document[list];
  const std::vector<std::string> names = material_names(asset.root());
  for (std::size_t i = 0; i < names.size(); ++i) made.lists["materials"][i]["name"] = names[i];
  const std::int64_t dropped = drop_further_sets(made.lists["materials"]);
  if (dropped > 0)
    made.warnings.push_back(
        {"left-out-textures",
         std::string(asset.file().name) +
             ": textures of further sets of texture coordinates are left out, since a scene that "
             "becomes one mesh has one",
         dropped});
  std::set<std::string> extensions;
  add_extensions(made.lists, extensions);
  for (const char* list : {"extensionsUsed", "extensionsRequired"})
    for (const json& name : document.value(list, json::array()))
      if (extensions.contains(name.get<std::string>())) made.lists[list].push_back(name);
  if (!made.lists.contains("images")) return made;
  std::vector<std::string> missing;
  for (std::size_t i = 0; i < made.lists["images"].size(); ++i) {
    json& image = made.lists["images"][i];
    const JsonPlace place = asset.root()["images"][static_cast<std::int64_t>(i)];
    const auto uri = place.find("uri");
    const AssetImage found = asset_image(asset, static_cast<std::int64_t>(i));
    made.images.push_back({image.value("mimeType", found.type), {}, {}});
    if (!found.missing.empty()) {
      made.images.back().type = found.type;
      missing.push_back(found.missing);
    } else if (const auto file = uri ? decode_uri_path(uri->text()) : std::nullopt;
               file && !is_data_uri(uri->text())) {
      made.images.back().path = asset.file().path.parent_path() / *file;
    }
    made.images.back().bytes.assign(found.bytes.begin(), found.bytes.end());
    image.erase("uri");
    image.erase("bufferView");
  }
  if (!missing.empty()) made.warnings.push_back(missing_images(missing));
  return made;
}

}  // namespace

std::string valid_utf8(const std::string& text) {
  const json value = text;
  return json::parse(value.dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

std::optional<glm::dvec3> GltfMaterials::display_color(std::string_view name) const {
  if (!lists.contains("materials")) return std::nullopt;
  const std::string wanted = valid_utf8(std::string(name));
  for (const json& material : lists["materials"]) {
    if (material.value("name", std::string()) != wanted) continue;
    const json factor = material.value("pbrMetallicRoughness", json::object())
                            .value("baseColorFactor", json::array());
    if (factor.size() < 3) return std::nullopt;
    glm::dvec3 color;
    for (int k = 0; k < 3; ++k) {
      const double linear = std::clamp(factor[k].get<double>(), 0.0, 1.0);
      color[k] = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    }
    return color;
  }
  return std::nullopt;
}

void GltfMaterials::apply(GltfDocument& document, std::string_view folder) const {
  std::map<std::string, const json*> by_name;
  if (lists.contains("materials"))
    for (const json& material : lists["materials"])
      by_name[material["name"].get<std::string>()] = &material;
  bool has_any = false;
  for (json& material : document.json["materials"]) {
    const auto found = by_name.find(material.value("name", std::string()));
    if (found == by_name.end()) continue;
    has_any = true;
    const bool is_double_sided = !has_sides && material.value("doubleSided", false);
    material = *found->second;
    if (is_double_sided) material["doubleSided"] = true;
  }
  if (!has_any) return;
  for (const char* list : {"textures", "samplers", "images"})
    if (lists.contains(list)) document.json[list] = lists[list];
  for (const char* list : {"extensionsUsed", "extensionsRequired"})
    if (lists.contains(list)) add_names(lists[list], list, document.json);
  for (std::size_t i = 0; i < images.size(); ++i) {
    json& image = document.json["images"][i];
    if (folder.empty()) {
      image["mimeType"] = images[i].type;
      image["bufferView"] = document.add_view(images[i].bytes);
    } else {
      image["uri"] = std::string(folder) + image_name(i);
      image.erase("mimeType");
    }
  }
}

std::string GltfMaterials::image_name(std::size_t image) const {
  const std::string& type = images[image].type;
  const std::size_t slash = type.find('/');
  const std::string kind = slash == std::string::npos ? "bin" : type.substr(slash + 1);
  const bool is_plain =
      std::ranges::all_of(kind, [](char c) { return std::isalnum(static_cast<unsigned char>(c)); });
  return std::to_string(image) + "." + (kind == "jpeg" ? "jpg" : is_plain ? kind : "bin");
}

std::vector<std::string> material_names(const JsonPlace& root) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  const auto materials = root.find("materials");
  for (std::int64_t i = 0; materials && i < materials->array_size(); ++i) {
    const auto named = (*materials)[i].find("name");
    std::string name = named && named->is_text() ? named->text() : "";
    while (name.empty() || !taken.insert(name).second)
      name += (name.empty() ? "material_" : "_") + std::to_string(i);
    names.push_back(std::move(name));
  }
  return names;
}

GltfMaterials materials_of(const GltfAsset& asset) {
  return guard_json(asset.file().name, [&] { return made_of(asset); });
}

}  // namespace planish
