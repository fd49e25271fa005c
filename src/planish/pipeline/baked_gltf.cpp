#include "planish/pipeline/baked_gltf.h"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "planish/core/formatted.h"
#include "planish/core/json.h"
#include "planish/core/number_text.h"
#include "planish/files/gltf/asset/image_type.h"
#include "planish/files/gltf/asset/json_guard.h"
#include "planish/files/gltf/asset/primitive_parts.h"
#include "planish/files/gltf/normal_texture.h"

namespace planish {
namespace {

using nlohmann::json;

// As plain materials of surfaces are.
constexpr double kRoughness = 0.5;

// What a material's normal texture adds; empty where it has none that can be read.
NormalDetail detail_of(const json& lists, const json& material, std::span<const std::byte> bytes,
                       const std::string& where, const Callbacks& callbacks) {
  auto image = read_image(bytes);
  if (!image) {
    callbacks.warn({"bake-unread-texture",
                    where +
                        ": its normal texture is no PNG or JPEG that can be read, and gives way "
                        "to the baked one without it; convert it to PNG first"});
    return {};
  }
  const auto texture = std::make_shared<const NormalTexture>(std::move(*image), lists, material);
  return [texture](const glm::dvec2& uv) { return texture->at(uv); };
}

// Of the mesh's groups; of a mesh without any one of no name.
std::vector<FaceGroup> named_groups(const PolygonMesh& mesh) {
  return mesh.groups.empty() ? std::vector<FaceGroup>(1) : mesh.groups;
}

}  // namespace

BakedSurface::BakedSurface(const FittedMesh& fitted, const SurfaceBlocks& low,
                           const SurfaceBlocks& fine, const GltfMaterials& materials,
                           const BakeFileOptions& options)
    : materials_(materials) {
  const PolygonMesh& mesh = fitted.mesh;
  BakeMapsOptions wanted{.size = options.size,
                         .maps = {},
                         .map_of_group = {},
                         .name = options.name,
                         .callbacks = options.callbacks};
  std::vector<std::string> names;  // of materials, by map
  for (const FaceGroup& group : named_groups(mesh)) {
    const std::string name = valid_utf8(group.material.empty() ? group.name : group.material);
    const auto known = std::ranges::find(names, name);
    wanted.map_of_group.push_back(static_cast<int>(known - names.begin()));
    if (known == names.end()) names.push_back(name);
  }
  settle_maps(mesh, wanted);
  json& lists = materials_.lists;
  std::vector<std::size_t> places;  // of the materials, by map
  for (const std::string& name : names) {
    json& all = lists["materials"];
    if (all.is_null()) all = json::array();
    const auto found =
        std::ranges::find_if(all, [&](const json& material) { return material["name"] == name; });
    const auto place = static_cast<std::size_t>(found - all.begin());
    places.push_back(place);
    WantedMap& map = wanted.maps.emplace_back();
    map.material = name;
    if (found == all.end()) {
      all.push_back(
          {{"name", name},
           {"doubleSided", options.double_sided},
           {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", kRoughness}}}});
      continue;
    }
    const std::int64_t image = normal_image(lists, *found);
    if (image >= 0 && image < std::ssize(materials_.images))
      map.detail =
          detail_of(lists, *found, materials_.images[static_cast<std::size_t>(image)].bytes,
                    options.name + ": material " + quote(name), options.callbacks);
  }
  const std::vector<int> sets = wanted.sets();
  for (const int set : sets) in_groups_.push_back(set >= 0 ? 1 : 0);
  const LevelUvs uvs(low, {});
  tangents_ = surface_tangents(low, uvs.tangents(sets));
  maps_ = bake_maps(mesh, low, tangents_, fine, {}, wanted);
  for (std::size_t m = 0; m < maps_.size(); ++m) {
    if (maps_[m].png.empty()) continue;
    json& images = lists["images"];
    set_normal_texture(lists, lists["materials"][places[m]], std::ssize(images), 0);
    images.push_back({{"mimeType", "image/png"}});
    GltfImage& image = materials_.images.emplace_back(GltfImage{"image/png", {}, {}});
    image.bytes.assign(maps_[m].png.begin(), maps_[m].png.end());
  }
}

void BakedSurface::add_to(GltfOptions& options) const {
  options.attributes.push_back({.name = "TANGENT",
                                .width = 4,
                                .values = tangents_.values,
                                .of_uvs = true,
                                .further = tangents_.further,
                                .further_values = tangents_.further_values,
                                .in_groups = in_groups_});
  options.materials = &materials_;
}

BakedAssetMesh::BakedAssetMesh(const GltfAsset& asset, const AssetMesh& mesh,
                               const FittedMesh& fitted, const SurfaceBlocks& low,
                               const AssetAttributes& attributes, const SurfaceBlocks& fine,
                               const BakeFileOptions& options) {
  const json& root = asset.root().value();
  BakeMapsOptions wanted{.size = options.size,
                         .maps = {},
                         .map_of_group = {},
                         .name = options.name,
                         .callbacks = options.callbacks};
  guard_json(asset.file().name, [&] {
    std::map<std::int64_t, int> map_of_material;
    const json& primitives = root["meshes"][mesh.number]["primitives"];
    const std::vector<std::string> names = material_names(asset.root());
    for (const AssetGroup& group : mesh.vertices.groups) {
      const std::int64_t number = primitives[group.primitive].value("material", std::int64_t{-1});
      const auto [known, is_new] =
          map_of_material.try_emplace(number, static_cast<int>(wanted.maps.size()));
      wanted.map_of_group.push_back(known->second);
      if (!is_new) continue;
      WantedMap& map = wanted.maps.emplace_back();
      map.set = group.tangent_set;
      if (number < 0) continue;
      map.material = names[static_cast<std::size_t>(number)];
      const json& material = root["materials"][number];
      if (const std::int64_t image = normal_image(root, material); image >= 0)
        map.detail =
            detail_of(root, material, asset_image(asset, image).bytes,
                      options.name + ": material " + quote(map.material), options.callbacks);
    }
    for (std::size_t g = 0; g < wanted.map_of_group.size(); ++g)
      if (mesh.vertices.groups[g].tangent_set < 0)
        std::ranges::replace(wanted.map_of_group, int{wanted.map_of_group[g]}, -1);
    return true;
  });
  try {
    settle_maps(fitted.mesh, wanted);
    maps_ =
        bake_maps(fitted.mesh, low, attributes.tangents(), fine, mesh.vertices.further_uvs, wanted);
    map_of_group_ = wanted.map_of_group;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnusableMesh) throw;
    why_none_ = error.what();
  }
}

void BakedAssetMesh::add_to(AssetSurface& surface) const {
  if (maps_.empty()) return;
  for (const BakedMap& map : maps_) surface.normal_maps.push_back({map.png, map.set});
  surface.map_of_group = map_of_group_;
}

}  // namespace planish
