// Based on: Khronos Group, "glTF 2.0 Specification", 2021. The asset's own JSON is changed in
// place: tinygltf, which writes what is new (gltf_document.h), drops keys that it does not know.
#include "planish/files/gltf/asset/asset_document.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/core/version.h"
#include "planish/files/gltf/asset/image_type.h"
#include "planish/files/gltf/asset/primitive_parts.h"
#include "planish/files/gltf/asset/write_asset.h"
#include "planish/files/gltf/draco_stream.h"
#include "planish/files/gltf/gltf_layout.h"
#include "planish/files/gltf/meshopt_stream.h"
#include "planish/files/gltf/normal_texture.h"

namespace planish {
namespace {

using nlohmann::json;

constexpr const char* kQuantization = "KHR_mesh_quantization";

constexpr std::string_view kTarget = "target/";

// What layers have with the group that they lie on: places and how they move.
bool is_of_surface(std::string_view attribute) {
  const std::string_view name = attribute.substr(attribute.rfind('/') + 1);
  return name == "POSITION" || name == "NORMAL" || name.starts_with("JOINTS_") ||
         name.starts_with("WEIGHTS_");
}

// The attributes of a group, or of a layer on it, of all that its vertices have.
json own_attributes(const json& made, const AssetGroup& group, const AssetLayer* layer) {
  const int depth = layer == nullptr ? 0 : layer->depth;
  const int first_set = layer == nullptr ? 0 : layer->first_uv_set;
  json attributes = json::object();
  for (const auto& [name, number] : made.items()) {
    if (const int set = uv_set(name); set >= 0) {
      if (set >= first_set && set < first_set + group.uv_sets_at(depth))
        attributes[uv_name(set - first_set)] = number;
    } else if (depth == 0) {
      if (!name.starts_with("layer/")) attributes[name] = number;
    } else if (is_of_surface(name)) {
      attributes[name] = number;
    } else if (const std::string own = layer_name(depth, ""); name.starts_with(own)) {
      attributes[name.substr(own.size())] = number;
    }
  }
  return attributes;
}

// "target/2/POSITION" are attributes of morph targets.
json primitive_of(const json& attributes, const json& indices, const json& rest,
                  const std::vector<std::int64_t>& accessors) {
  json primitive = rest;
  const auto place = [&](const json& number) { return accessors[number.get<std::size_t>()]; };
  for (const auto& [name, number] : attributes.items()) {
    if (!name.starts_with(kTarget)) {
      primitive["attributes"][name] = place(number);
      continue;
    }
    const std::size_t slash = name.find('/', kTarget.size());
    const std::size_t target = std::stoul(name.substr(kTarget.size()));
    while (primitive["targets"].size() <= target) primitive["targets"].push_back(json::object());
    primitive["targets"][target][name.substr(slash + 1)] = place(number);
  }
  primitive["indices"] = place(indices);
  return primitive;
}

}  // namespace

std::int64_t AssetDocument::Places::next(json& list) {
  if (list.is_null()) list = json::array();
  if (free.empty()) {
    list.push_back(nullptr);
    return std::ssize(list) - 1;
  }
  return free.extract(free.begin()).value();
}

AssetDocument::AssetDocument(const GltfAsset& asset, const std::set<std::int64_t>& replaced_meshes,
                             bool keeps_files)
    : asset_(asset), json_(asset.root().value()), keeps_files_(keeps_files) {
  FreePlaces free = free_places(json_, replaced_meshes);
  accessors_.free = std::move(free.accessors);
  views_.free = std::move(free.views);
  for (std::size_t m = 0; m < json_["meshes"].size(); ++m)
    keeps_vertices_ |= !replaced_meshes.contains(static_cast<std::int64_t>(m)) ||
                       !std::ranges::all_of(json_["meshes"][m]["primitives"], is_surface);
  keep_views();
  keep_images();
  json_["asset"]["generator"] = "planish " PLANISH_VERSION;
}

std::uint64_t AssetDocument::keep(std::span<const std::byte> bytes) {
  const std::uint64_t offset = buffer_bytes_;
  kept_.push_back(bytes);
  buffer_bytes_ += padded(bytes.size());
  return offset;
}

// What was packed by meshopt comes unpacked: its streams name buffers by themselves.
void AssetDocument::keep_views() {
  if (!json_.contains("bufferViews")) return;
  json& views = json_["bufferViews"];
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto number = static_cast<std::int64_t>(i);
    if (views_.free.contains(number)) continue;
    const std::span<const std::byte> bytes = asset_.source().view(number);
    views[i]["buffer"] = 0;
    views[i]["byteOffset"] = keep(bytes);
    views[i]["byteLength"] = bytes.size();
    if (!views[i].contains("extensions")) continue;
    views[i]["extensions"].erase(kMeshoptExtension);
    if (views[i]["extensions"].empty()) views[i].erase("extensions");
  }
}

// Images beside the asset stay there where the file comes there, too; addresses elsewhere stay
// anywhere.
bool AssetDocument::stays(const JsonPlace& uri) const {
  if (uri.text().find("://") != std::string::npos) return true;
  if (!keeps_files_) return false;
  if (is_data_uri(uri.text())) return true;
  const auto name = decode_uri_path(uri.text());
  std::error_code error;
  return name && std::filesystem::is_regular_file(asset_.file().path.parent_path() / *name, error);
}

void AssetDocument::keep_images() {
  std::vector<std::string> missing;
  const auto images = asset_.root().find("images");
  for (std::int64_t i = 0; images && i < images->array_size(); ++i) {
    const auto uri = (*images)[i].find("uri");
    if (!uri || stays(*uri)) continue;
    const AssetImage found = asset_image(asset_, i);
    if (!found.missing.empty()) missing.push_back(found.missing);
    json& views = json_["bufferViews"];
    const std::int64_t view = views_.next(views);
    views[view] = {
        {"buffer", 0}, {"byteOffset", keep(found.bytes)}, {"byteLength", found.bytes.size()}};
    json& image = json_["images"][i];
    if (!image.contains("name") && !is_data_uri(uri->text())) image["name"] = image["uri"];
    if (!image.contains("mimeType") || !found.missing.empty()) image["mimeType"] = found.type;
    image["bufferView"] = view;
    image.erase("uri");
  }
  if (!missing.empty()) warnings_.push_back(missing_images(missing));
}

// Their places in the document.
std::vector<std::int64_t> AssetDocument::append_accessors(const GltfDocument& document,
                                                          const json& made) {
  std::vector<std::int64_t> views, accessors;
  for (const json& view : made["bufferViews"]) {
    views.push_back(views_.next(json_["bufferViews"]));
    json& to = json_["bufferViews"][views.back()] = view;
    const bool is_packed = to["buffer"] == 1;
    to["byteOffset"] =
        to.value("byteOffset", std::uint64_t{0}) + (is_packed ? decoded_bytes_ : buffer_bytes_);
    if (!is_packed) continue;
    json& stream = to["extensions"][kMeshoptExtension];
    stream["byteOffset"] = stream.value("byteOffset", std::uint64_t{0}) + buffer_bytes_;
  }
  for (const json& accessor : made["accessors"]) {
    accessors.push_back(accessors_.next(json_["accessors"]));
    json& to = json_["accessors"][accessors.back()] = accessor;
    to["bufferView"] = views[to["bufferView"].get<std::size_t>()];
  }
  buffer_bytes_ += document.buffer_bytes;
  decoded_bytes_ += document.decoded_bytes;
  new_extensions_.insert(document.extensions.begin(), document.extensions.end());
  return accessors;
}

// With what the mesh has besides triangles.
json AssetDocument::primitives_of(std::int64_t mesh, const AssetVertices& vertices,
                                  const GltfDocument& document, const json& made) {
  const std::vector<std::int64_t> accessors = append_accessors(document, made);
  const json& given = asset_.root().value()["meshes"][mesh]["primitives"];
  const json& primitives = made["meshes"][0]["primitives"];
  json all = json::array();
  const auto add = [&](std::size_t i, int depth) {
    const auto number = static_cast<std::size_t>(std::max(document.primitives[i].group, 0));
    const AssetGroup& group = vertices.groups[number];
    const AssetLayer* const layer = group.layer(depth);
    if (depth > 0 && layer == nullptr) return;
    json rest = without_vertices(given[layer == nullptr ? group.primitive : layer->primitive]);
    drop_untrue_extensions(
        rest, {asset_.root().value(), vertices, document.primitives[i].encodes_ngons}, lost_);
    all.push_back(primitive_of(own_attributes(primitives[i]["attributes"], group, layer),
                               primitives[i]["indices"], rest, accessors));
  };
  // Layers after what they lie on, as the file had them.
  for (int depth = 0; depth <= vertices.layer_depth(); ++depth)
    for (std::size_t i = 0; i < primitives.size(); ++i) add(i, depth);
  for (const json& primitive : given)
    if (!is_surface(primitive)) all.push_back(primitive);
  return all;
}

void AssetDocument::replace(std::int64_t mesh, const AssetVertices& vertices,
                            const GltfDocument& document, const json& made, double least_coverage) {
  json primitives = primitives_of(mesh, vertices, document, made);
  json_["meshes"][mesh]["primitives"] = std::move(primitives);
  drop_untrue_extensions(json_["meshes"][mesh], {asset_.root().value(), vertices}, lost_);
  levels_[mesh] = {{mesh, document.scale, document.translation, least_coverage}};
}

void AssetDocument::add_level(std::int64_t mesh, const AssetVertices& vertices,
                              const GltfDocument& document, const json& made,
                              double least_coverage) {
  std::vector<MeshLevel>& levels = levels_.at(mesh);
  json& meshes = json_["meshes"];
  json level = meshes[mesh];
  level["primitives"] = primitives_of(mesh, vertices, document, made);
  if (level.contains("name"))
    level["name"] = formatted("{}_LOD{}", level["name"].get<std::string>(), levels.size());
  levels.push_back({std::ssize(meshes), document.scale, document.translation, least_coverage});
  meshes.push_back(std::move(level));
  new_extensions_.insert(kLodExtension);
}

std::int64_t AssetDocument::add_image(std::span<const std::byte> bytes, const std::string& type) {
  json& views = json_["bufferViews"];
  const std::int64_t view = views_.next(views);
  views[view] = {{"buffer", 0}, {"byteOffset", keep(bytes)}, {"byteLength", bytes.size()}};
  json& images = json_["images"];
  images.push_back({{"bufferView", view}, {"mimeType", type}});
  return std::ssize(images) - 1;
}

namespace {

constexpr const char* kVariants = "KHR_materials_variants";

// use(number) for each place where a primitive names a material.
template <class Json, class Use>
void for_materials(Json& primitive, const Use& use) {
  if (primitive.contains("material")) use(primitive["material"]);
  if (!primitive.contains("extensions") || !primitive["extensions"].contains(kVariants)) return;
  for (auto& mapping : primitive["extensions"][kVariants]["mappings"])
    if (mapping.contains("material")) use(mapping["material"]);
}

}  // namespace

// In the place of another one.
void AssetDocument::put_material(json& primitive, std::int64_t given, std::int64_t number) {
  primitive["material"] = number;
  bool has_others = false;
  for_materials(primitive, [&](json& material) {
    if (material == given) material = number;
    has_others |= material != number;
  });
  if (has_others)
    warnings_.push_back(
        {"bake-variants", std::string(asset_.file().name) +
                              ": variants of materials keep the normal textures that they have; "
                              "only the material of a primitive itself gets a baked one"});
}

void AssetDocument::set_normal_maps(std::int64_t mesh, const GltfDocument& document,
                                    const AssetSurface& surface,
                                    std::span<const std::int64_t> images) {
  const auto map_of = [&](std::size_t primitive) {
    return surface
        .map_of_group[static_cast<std::size_t>(std::max(document.primitives[primitive].group, 0))];
  };
  std::vector<std::vector<json*>> of_maps(images.size());
  json& primitives = json_["meshes"][mesh]["primitives"];
  for (std::size_t i = 0; i < document.primitives.size(); ++i)
    if (const int map = map_of(i); map >= 0 && images[static_cast<std::size_t>(map)] >= 0)
      of_maps[static_cast<std::size_t>(map)].push_back(&primitives[i]);
  for (std::size_t m = 0; m < images.size(); ++m) {
    if (of_maps[m].empty()) continue;
    json& materials = json_["materials"];
    if (materials.is_null()) materials = json::array();
    const std::int64_t given = of_maps[m].front()->value("material", std::int64_t{-1});
    // Names of it elsewhere than in these primitives.
    std::int64_t uses = 0, own = 0;
    for (json& any : json_["meshes"])
      for (json& primitive : any["primitives"])
        for_materials(primitive, [&](const json& number) { uses += number == given ? 1 : 0; });
    for (json* primitive : of_maps[m])
      for_materials(*primitive, [&](const json& number) { own += number == given ? 1 : 0; });
    std::int64_t number = given;
    if (given < 0 || uses > own) {
      json copy = given < 0 ? json::object() : materials[given];
      number = std::ssize(materials);
      materials.push_back(std::move(copy));
    }
    set_normal_texture(json_, json_["materials"][number], images[m], surface.normal_maps[m].set);
    for (json* primitive : of_maps[m]) put_material(*primitive, given, number);
  }
}

void AssetDocument::add_extras(const json& extras) {
  if (!extras.is_object()) return;
  json& own = json_["asset"]["extras"];
  if (own.is_null()) own = json::object();
  if (!own.is_object()) return;
  for (const auto& [key, value] : extras.items())
    if (!own.contains(key)) own[key] = value;
}

// Where fewer came than gave way. Numbers stay, so only the last of a list can go.
void AssetDocument::drop_unused_places(const char* list, Places& places, const json& filler) {
  if (!json_.contains(list)) return;
  json& all = json_[list];
  while (!places.free.empty() && *places.free.rbegin() == std::ssize(all) - 1) {
    places.free.erase(std::prev(places.free.end()));
    all.erase(all.size() - 1);
  }
  for (const std::int64_t place : places.free) all[place] = filler;
  if (all.empty()) json_.erase(list);
}

void AssetDocument::tell_lost_extensions() {
  if (lost_.empty()) return;
  const auto required = asset_.root().find("extensionsRequired");
  for (std::int64_t i = 0; required && i < required->array_size(); ++i)
    if (lost_.contains((*required)[i].text()))
      (*required)[i].fail(
          "{} describes triangles that give way, and cannot be kept; save the file "
          "without it",
          quote((*required)[i].text()));
  std::int64_t places = 0;
  for (const auto& [name, count] : lost_) places += count;
  warnings_.push_back({"left-out-extensions",
                       formatted("{}: left out, since they describe the triangles that give way: "
                                 "{}",
                                 asset_.file().name, names_of(lost_)),
                       places});
}

void AssetDocument::settle_extensions() {
  drop_untrue_scenes(json_, lost_);
  tell_lost_extensions();
  // What concerns bytes that are unpacked now, or attributes that gave way.
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    std::set<std::string> names;
    if (json_.contains(list))
      for (const json& name : json_[list]) names.insert(name.get<std::string>());
    names.erase(kMeshoptExtension);
    for (const auto& [name, count] : lost_)
      if (!has_extension(json_, name)) names.erase(name);
    if (!keeps_vertices_) names.erase(kDracoExtension), names.erase(kQuantization);
    const bool is_required = list == std::string_view("extensionsRequired");
    // Readers that know no levels of detail show the finest.
    for (const std::string& name : new_extensions_)
      if (!is_required || name != kLodExtension) names.insert(name);
    json_[list] = names;
    if (names.empty()) json_.erase(list);
  }
}

std::string AssetDocument::text(const std::string& uri) {
  constexpr int kFloat = 5126;
  for (const auto& [mesh, levels] : levels_) place_levels(json_, levels);
  drop_unused_places("accessors", accessors_,
                     {{"componentType", kFloat}, {"count", 1}, {"type", "SCALAR"}});
  drop_unused_places("bufferViews", views_, {{"buffer", 0}, {"byteLength", 1}});
  settle_extensions();
  json& buffers = json_["buffers"] = json::array();
  buffers.push_back({{"byteLength", buffer_bytes_}});
  if (!uri.empty()) buffers[0]["uri"] = uri;
  if (decoded_bytes_ > 0)
    buffers.push_back({{"byteLength", decoded_bytes_},
                       {"extensions", {{kMeshoptExtension, {{"fallback", true}}}}}});
  return json_.dump(uri.empty() ? -1 : 2, ' ', false, json::error_handler_t::replace);
}

}  // namespace planish
