#include "planish/files/gltf/asset/asset_contents.h"

#include <iterator>
#include <set>

#include "planish/core/json.h"
#include "planish/files/gltf/asset/json_guard.h"
#include "planish/files/gltf/asset/primitive_parts.h"
#include "planish/files/gltf/asset/replaced_geometry.h"
#include "planish/files/gltf/draco_stream.h"
#include "planish/files/gltf/gltf_buffer.h"
#include "planish/files/gltf/meshopt_stream.h"

namespace planish {
namespace {

using nlohmann::json;

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
