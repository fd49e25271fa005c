#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/json_fwd.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/gltf_json.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/images.h"
#include "planish/files/mesh_file.h"

namespace planish {
namespace {

constexpr const char* kLodExtension = "MSFT_lod";

// A mesh that stands for another, and how its nodes place it.
struct MeshLevel {
  std::int64_t mesh = 0;  // in the document
  double scale = 1;       // of the grid of compressed positions
  glm::dvec3 translation{0.0};
  double least_coverage = 0;  // of the screen, down to which it is shown

  [[nodiscard]] bool is_placed() const { return scale != 1 || translation != glm::dvec3(0.0); }
};

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

// Lets every node of a mesh show `levels` in its place, of which the first has the mesh's number:
// a single one is the node's own, or a child's where it is scaled; several are levels of detail by
// MSFT_lod, finest first. Those of a node without a skin become children, so that the node's own
// children and its animation move all of them; those of a skinned one, whose place means nothing,
// stand beside it. Skin, weights and instances come to each, animations of weights, too. New nodes
// follow those that there are. Throws Error{InvalidArgument} where a node has levels of detail
// already, naming it.
// Based on: Microsoft, "MSFT_lod", glTF 2.0 vendor extension.
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

// Based on: Khronos Group, "glTF 2.0 Specification", 2021. The asset's own JSON is changed in
// place: tinygltf, which makes what is new (gltf_payload.h), drops keys that it does not know.

constexpr const char* kQuantization = "KHR_mesh_quantization";
constexpr const char* kVariants = "KHR_materials_variants";

// What layers have with the group that they lie on: places and how they move.
bool is_of_surface(std::string_view attribute) {
  const std::string_view name = attribute.substr(attribute.rfind('/') + 1);
  return name == "POSITION" || name == "NORMAL" || name.starts_with("JOINTS_") ||
         name.starts_with("WEIGHTS_");
}

// The primitive of a group, or of a layer on it, of one with all that its vertices have.
GltfPrimitive own_primitive(const GltfPrimitive& made, const AssetGroup& group,
                            const AssetLayer* layer) {
  const int depth = layer == nullptr ? 0 : layer->depth;
  const int first_set = layer == nullptr ? 0 : layer->first_uv_set;
  GltfPrimitive own{.attributes = {}, .indices = made.indices};
  for (const auto& [name, array] : made.attributes) {
    if (const int set = uv_set(name); set >= 0) {
      if (set >= first_set && set < first_set + group.uv_sets_at(depth))
        own.attributes[uv_name(set - first_set)] = array;
    } else if (depth == 0) {
      if (!name.starts_with("layer/")) own.attributes[name] = array;
    } else if (is_of_surface(name)) {
      own.attributes[name] = array;
    } else if (const std::string of_layer = layer_name(depth, ""); name.starts_with(of_layer)) {
      own.attributes[name.substr(of_layer.size())] = array;
    }
  }
  return own;
}

// use(number) for each place where a primitive names a material.
template <class Json, class Use>
void for_materials(Json& primitive, const Use& use) {
  if (primitive.contains("material")) use(primitive["material"]);
  if (!primitive.contains("extensions") || !primitive["extensions"].contains(kVariants)) return;
  for (auto& mapping : primitive["extensions"][kVariants]["mappings"])
    if (mapping.contains("material")) use(mapping["material"]);
}

// An asset's document while surfaces come in the place of triangles. New accessors and buffer
// views take the places of those that nothing else names, so that no number in the rest of the
// document changes, which may be one of an extension that nobody here knows.
class AssetDocument {
 public:
  // `keeps_files`: images beside the asset, and those in data URIs, stay there; else all come into
  // the buffer. Throws Error{UnreadableInput} where the
  // asset names bytes that are not there.
  AssetDocument(const GltfAsset& asset, const std::set<std::int64_t>& replaced_meshes,
                bool keeps_files);

  // Puts a surface in the place of a mesh's triangles. Another one of the same mesh, coarser than
  // those before it, becomes a level of detail: see place_levels(). It has what the mesh has
  // besides triangles, too.
  void add(const AssetSurface& surface, const std::shared_ptr<const GltfPayload>& payload);
  // An image in the buffer; before the first surface. Returns its number.
  std::int64_t add_image(std::span<const std::byte> bytes, const std::string& type);
  // Gives the materials of a surface that came last these normal textures: `images` of its maps.
  // Materials that other primitives have, too, are copied.
  void set_normal_maps(const AssetSurface& surface, const GltfPayload& payload,
                       std::span<const std::int64_t> images);
  // Adds the extras of `made` to those of the asset that it does not have already.
  void add_extras(const json& made);
  // The whole. Throws Error{UnreadableInput} where the asset requires an extension that its new
  // triangles make untrue.
  [[nodiscard]] GltfDocument finish();

  // What of the asset could not come along.
  [[nodiscard]] const std::vector<Warning>& warnings() const { return warnings_; }

 private:
  void keep_views();
  [[nodiscard]] bool stays(const JsonPlace& uri) const;
  void keep_images();
  void put_material(json& primitive, std::int64_t given, std::int64_t number);
  json primitives_of(const AssetSurface& surface, const GltfPayload& payload);
  void drop_unused_places(const char* list, GltfDocument::Places& places, const json& filler);
  void tell_lost_extensions();
  void settle_extensions();

  const GltfAsset& asset_;
  GltfDocument document_;
  json& json_ = document_.json;
  bool keeps_files_;
  std::vector<Warning> warnings_;
  LostExtensions lost_;
  std::map<std::int64_t, std::vector<MeshLevel>> levels_;  // by the mesh that gave way
  bool keeps_vertices_ = false;                            // of some primitive
};

AssetDocument::AssetDocument(const GltfAsset& asset, const std::set<std::int64_t>& replaced_meshes,
                             bool keeps_files)
    : asset_(asset), keeps_files_(keeps_files) {
  json_ = asset.root().value();
  FreePlaces free = free_places(json_, replaced_meshes);
  document_.accessors.free = std::move(free.accessors);
  document_.views.free = std::move(free.views);
  for (std::size_t m = 0; m < json_["meshes"].size(); ++m)
    keeps_vertices_ |= !replaced_meshes.contains(static_cast<std::int64_t>(m)) ||
                       !std::ranges::all_of(json_["meshes"][m]["primitives"], is_surface);
  keep_views();
  keep_images();
  json_["asset"]["generator"] = "planish " PLANISH_VERSION;
}

// What was packed by meshopt comes unpacked: its streams name buffers by themselves.
void AssetDocument::keep_views() {
  if (!json_.contains("bufferViews")) return;
  json& views = json_["bufferViews"];
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto number = static_cast<std::int64_t>(i);
    if (document_.views.free.contains(number)) continue;
    const std::span<const std::byte> bytes = asset_.source().view(number);
    views[i]["buffer"] = 0;
    views[i]["byteOffset"] = document_.keep(bytes);
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
  return name &&
         std::filesystem::is_regular_file(asset_.file().path.parent_path() / path_of(*name), error);
}

void AssetDocument::keep_images() {
  std::vector<std::string> missing;
  const auto images = asset_.root().find("images");
  for (std::int64_t i = 0; images && i < images->array_size(); ++i) {
    const auto uri = (*images)[i].find("uri");
    if (!uri || stays(*uri)) continue;
    const AssetImage found = asset_image(asset_, i);
    if (!found.missing.empty()) missing.push_back(found.missing);
    json& image = json_["images"][i];
    if (!image.contains("name") && !is_data_uri(uri->text())) image["name"] = image["uri"];
    if (!image.contains("mimeType") || !found.missing.empty()) image["mimeType"] = found.type;
    image["bufferView"] = document_.add_view(found.bytes);
    image.erase("uri");
  }
  if (!missing.empty()) warnings_.push_back(missing_images(missing));
}

// With what the mesh has besides triangles.
json AssetDocument::primitives_of(const AssetSurface& surface, const GltfPayload& payload) {
  const std::vector<std::int64_t> accessors = document_.add(payload);
  const AssetVertices& vertices = *surface.vertices;
  const json& given = asset_.root().value()["meshes"][surface.mesh]["primitives"];
  json all = json::array();
  const auto add = [&](const GltfPrimitive& made, int depth) {
    const AssetGroup& group = vertices.groups[static_cast<std::size_t>(std::max(made.group, 0))];
    const AssetLayer* const layer = group.layer(depth);
    if (depth > 0 && layer == nullptr) return;
    json rest = without_vertices(given[layer == nullptr ? group.primitive : layer->primitive]);
    drop_untrue_extensions(rest, {asset_.root().value(), vertices, made.encodes_ngons}, lost_);
    all.push_back(primitive_json(own_primitive(made, group, layer), accessors, std::move(rest)));
  };
  // Layers after what they lie on, as the file had them.
  for (int depth = 0; depth <= vertices.layer_depth(); ++depth)
    for (const GltfPrimitive& primitive : payload.primitives) add(primitive, depth);
  for (const json& primitive : given)
    if (!is_surface(primitive)) all.push_back(primitive);
  return all;
}

void AssetDocument::add(const AssetSurface& surface,
                        const std::shared_ptr<const GltfPayload>& payload) {
  json& meshes = json_["meshes"];
  std::vector<MeshLevel>& levels = levels_[surface.mesh];
  json primitives = primitives_of(surface, *payload);
  MeshLevel level{surface.mesh, payload->scale, payload->translation, surface.least_coverage};
  if (levels.empty()) {
    meshes[surface.mesh]["primitives"] = std::move(primitives);
    drop_untrue_extensions(meshes[surface.mesh], {asset_.root().value(), *surface.vertices}, lost_);
  } else {
    json mesh = meshes[surface.mesh];
    mesh["primitives"] = std::move(primitives);
    if (mesh.contains("name"))
      mesh["name"] = formatted("{}_LOD{}", mesh["name"].get<std::string>(), levels.size());
    level.mesh = std::ssize(meshes);
    meshes.push_back(std::move(mesh));
    document_.extensions.insert(kLodExtension);
  }
  levels.push_back(level);
  document_.parts.emplace_back(
      [payload](std::span<const ByteSink> sinks) { payload->write(sinks); });
}

std::int64_t AssetDocument::add_image(std::span<const std::byte> bytes, const std::string& type) {
  json& images = json_["images"];
  images.push_back({{"bufferView", document_.add_view(bytes)}, {"mimeType", type}});
  return std::ssize(images) - 1;
}

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

void AssetDocument::set_normal_maps(const AssetSurface& surface, const GltfPayload& payload,
                                    std::span<const std::int64_t> images) {
  const auto map_of = [&](std::size_t primitive) {
    return surface
        .map_of_group[static_cast<std::size_t>(std::max(payload.primitives[primitive].group, 0))];
  };
  std::vector<std::vector<json*>> of_maps(images.size());
  json& primitives = json_["meshes"][surface.mesh]["primitives"];
  for (std::size_t i = 0; i < payload.primitives.size(); ++i)
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

void AssetDocument::add_extras(const json& made) {
  if (!made.contains("extras")) return;
  json& own = json_["asset"]["extras"];
  if (own.is_null()) own = json::object();
  if (!own.is_object()) return;
  for (const auto& [key, value] : made["extras"].items())
    if (!own.contains(key)) own[key] = value;
}

// Where fewer came than gave way. Numbers stay, so only the last of a list can go.
void AssetDocument::drop_unused_places(const char* list, GltfDocument::Places& places,
                                       const json& filler) {
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
    for (const std::string& name : document_.extensions)
      if (!is_required || name != kLodExtension) names.insert(name);
    json_[list] = names;
    if (names.empty()) json_.erase(list);
  }
}

GltfDocument AssetDocument::finish() {
  constexpr int kFloat = 5126;
  for (const auto& [mesh, levels] : levels_) place_levels(json_, levels);
  if (json_.contains("bufferViews"))
    for (json& view : json_["bufferViews"]) view.emplace("byteOffset", 0);
  drop_unused_places("accessors", document_.accessors,
                     {{"componentType", kFloat}, {"count", 1}, {"type", "SCALAR"}});
  drop_unused_places("bufferViews", document_.views, {{"buffer", 0}, {"byteLength", 1}});
  settle_extensions();
  return std::move(document_);
}

// By group, whether its triangles are to encode polygons; packing by Meshopt brings triangles into
// another order.
std::vector<std::uint8_t> ngon_groups(const GltfAsset& asset, const AssetSurface& one) {
  std::vector<std::uint8_t> flags;
  if (one.options.compression == GltfCompression::Meshopt) return flags;
  const json& primitives = asset.root().value()["meshes"][one.mesh]["primitives"];
  for (const AssetGroup& group : one.vertices->groups) {
    const json& given = primitives[group.primitive];
    flags.push_back(given.contains("extensions") && given["extensions"].contains(kNgonExtension));
  }
  return flags;
}

// Options of each surface that tell how far all of them are: first one after another is surveyed,
// or packed, then one after another is written.
std::vector<GltfOptions> options_of_all(const GltfAsset& asset,
                                        std::span<const AssetSurface> surfaces,
                                        const Callbacks& common,
                                        const std::shared_ptr<const bool>& is_writing) {
  double all = 0, done = 0;
  for (const AssetSurface& one : surfaces)
    all += static_cast<double>(one.surface->info().corner_count);
  std::vector<GltfOptions> options;
  const auto farthest = std::make_shared<double>(0);
  for (const AssetSurface& one : surfaces) {
    GltfOptions& own = options.emplace_back(one.options);
    own.ngon_groups = ngon_groups(asset, one);
    const double begin = done / all;
    done += static_cast<double>(one.surface->info().corner_count);
    const double end = done / all;
    const double first = own.compression == GltfCompression::None ? kGltfSurveyed : 1;
    // Where a survey ends and where writing begins are the same fraction, and not the same place.
    const auto place = [=](double fraction) {
      if (fraction < first || first == 1 || !*is_writing)
        return std::lerp(first * begin, first * end, fraction / first);
      return std::lerp(std::lerp(first, 1, begin), std::lerp(first, 1, end),
                       (fraction - first) / (1 - first));
    };
    own.callbacks.progress = {};
    if (common.progress)
      own.callbacks.progress = [report = common.progress, place, farthest](std::string_view step,
                                                                           double fraction) {
        *farthest = std::max(*farthest, place(fraction));
        report(step, *farthest);
      };
  }
  return options;
}

GltfDocument assembled(const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                       const Callbacks& common, bool is_glb, bool keeps_files) {
  std::set<std::int64_t> replaced;
  for (const AssetSurface& surface : surfaces) replaced.insert(surface.mesh);
  AssetDocument document(asset, replaced, keeps_files);
  // Images come before surfaces.
  std::vector<std::vector<std::int64_t>> images;
  for (const AssetSurface& surface : surfaces) {
    std::vector<std::int64_t>& of_maps = images.emplace_back();
    for (const AssetNormalMap& map : surface.normal_maps)
      of_maps.push_back(map.png.empty() ? -1 : document.add_image(map.png, "image/png"));
  }
  const auto is_writing = std::make_shared<bool>(false);
  const auto options = std::make_shared<const std::vector<GltfOptions>>(
      options_of_all(asset, surfaces, common, is_writing));
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const AssetSurface& one = surfaces[i];
    const GltfOptions& own = (*options)[i];
    const auto payload = std::make_shared<const GltfPayload>(payload_of(*one.surface, own, is_glb));
    document.add(one, payload);
    if (!one.normal_maps.empty()) document.set_normal_maps(one, *payload, images[i]);
    GltfOptions described = one.options;
    if (surfaces.size() > 1) described.extras.clear();
    document.add_extras(asset_json(described));
  }
  GltfDocument whole = document.finish();
  for (const Warning& warning : document.warnings()) common.warn(warning);
  // Payloads read their options.
  whole.parts.emplace(whole.parts.begin(),
                      [options, is_writing](std::span<const ByteSink>) { *is_writing = true; });
  return whole;
}

GltfDocument whole_asset(const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                         const Callbacks& common, bool is_glb, bool keeps_files) {
  return guard_json(asset.file().name,
                    [&] { return assembled(asset, surfaces, common, is_glb, keeps_files); });
}

bool is_same_folder(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  const auto named = [](const std::filesystem::path& folder) {
    return folder.empty() ? std::filesystem::path(".") : folder;
  };
  return std::filesystem::equivalent(named(a), named(b), error);
}

}  // namespace

GltfFile write_asset(const std::filesystem::path& path, const std::filesystem::path& folder,
                     const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                     const GltfOptions& common) {
  const HostScope host(common.callbacks);
  require_apart(asset.file().path, path, *format_of(path));
  const bool is_glb = info_of(*format_of(path)).format == FileFormat::Glb;
  const bool keeps_files = !is_glb && !asset.file().path.empty() &&
                           is_same_folder(asset.file().path.parent_path(), folder);
  return write_document(path, whole_asset(asset, surfaces, common.callbacks, is_glb, keeps_files),
                        common);
}

std::vector<std::byte> encode_asset(const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                                    const GltfOptions& common) {
  const HostScope host(common.callbacks);
  return encode_document(whole_asset(asset, surfaces, common.callbacks, true, false), common);
}

}  // namespace planish
