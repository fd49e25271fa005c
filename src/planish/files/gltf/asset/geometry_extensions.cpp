// Based on: Khronos Group's registry of glTF 2.0 extensions, and 3D Tiles' EXT_mesh_features and
// EXT_structural_metadata.
#include "planish/files/gltf/asset/geometry_extensions.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "planish/core/formatted.h"
#include "planish/core/json.h"
#include "planish/files/gltf/asset/asset_references.h"

namespace planish {
namespace {

using nlohmann::json;

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
