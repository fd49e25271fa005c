#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "planish/core/json_fwd.h"
#include "planish/files/gltf/asset/asset_vertices.h"

namespace planish {

/// Places in an asset's lists that only the triangles of some meshes name: what comes in their
/// place can have them.
struct FreePlaces {
  std::set<std::int64_t> accessors, views;
};
[[nodiscard]] FreePlaces free_places(const nlohmann::json& document,
                                     const std::set<std::int64_t>& replaced_meshes);

inline constexpr const char* kNgonExtension = "FB_ngon_encoding";
/// Of scenes: how many vertices and triangles they have.
inline constexpr const char* kCountsExtension = "FB_geometry_metadata";

/// Whether an extension of a mesh or of a primitive describes vertices, corners or triangles by
/// their numbers or accessors, so that it goes where those give way: what the table of
/// replaced_geometry.cpp says, of an extension that nobody here knows whether it names an
/// accessor or a buffer view under a name that the format has for them.
[[nodiscard]] bool describes_triangles(const std::string& name, const nlohmann::json& extension);

/// What a surface in the place of triangles tells its extensions.
struct NewGeometry {
  const nlohmann::json& document;
  const AssetVertices& vertices;
  bool encodes_ngons = false;  ///< FB_ngon_encoding holds of the new triangles
};

/// How many places have lost an extension, by its name.
using LostExtensions = std::map<std::string, std::int64_t>;

/// Takes out of `holder`, a mesh or a primitive that has its surface, the extensions and parts of
/// them that the surface makes untrue, and counts them.
void drop_untrue_extensions(nlohmann::json& holder, const NewGeometry& made, LostExtensions& lost);

/// The same of what scenes say of all triangles in them.
void drop_untrue_scenes(nlohmann::json& document, LostExtensions& lost);

/// "`EXT_mesh_manifold`, `CESIUM_primitive_outline` (3)".
[[nodiscard]] std::string names_of(const LostExtensions& lost);

/// Whether any object of the document has that extension.
[[nodiscard]] bool has_extension(const nlohmann::json& document, const std::string& name);

}  // namespace planish
