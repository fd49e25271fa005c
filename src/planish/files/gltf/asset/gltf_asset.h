#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/json_fwd.h"
#include "planish/files/gltf/asset/asset_vertices.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// What of a primitive is no vertex: material, extras, extensions. Primitives where that is equal
/// are one on the surface.
[[nodiscard]] nlohmann::json without_vertices(const nlohmann::json& primitive);

/// 2 of "meshes[4].primitives[2]".
[[nodiscard]] std::int64_t primitive_number(std::string_view path);

/// Whether a primitive has triangles with positions, of which a surface can be made.
[[nodiscard]] bool is_surface(const nlohmann::json& primitive);

/// The set of texture coordinates whose tangents a primitive's material asks for: that of its
/// normal texture, of a clear coat's, or of what shines along a direction; -1: it asks for none.
/// Source: glTF 2.0, sections 3.7.2.1 and 3.9.3; KHR_materials_clearcoat, _anisotropy.
[[nodiscard]] int tangent_set(const nlohmann::json& document, const nlohmann::json& primitive);

/// The set that a texture of a material names, KHR_texture_transform's where it has one.
[[nodiscard]] int set_of_texture(const nlohmann::json& texture);

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
/// gltf_asset.cpp says, of an extension that nobody here knows whether it names an
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

/// A mesh of an asset in its own coordinates.
struct AssetMesh {
  std::int64_t number = 0;  ///< in the file
  std::string name;         ///< "meshes[3]" where it has none
  MeshFile file;
  AssetVertices vertices;
};

/// A glTF file with all that it holds, whose triangle meshes are to give way to surfaces: nodes,
/// materials, textures, skins, animations and what nobody here knows stay as they are. One thread
/// at a time: what lies beside the file or is packed is fetched when it is first asked for.
class GltfAsset {
 public:
  /// The bytes must outlive it. Throws Error{UnreadableInput}, naming the place, where something in
  /// it names what is not there.
  explicit GltfAsset(const FileBytes& file, const GltfLimits& limits = {});

  /// The numbers of the meshes that have triangles, in order.
  [[nodiscard]] const std::vector<std::int64_t>& surfaces() const { return surfaces_; }
  /// How many corners such a mesh names by what the file says, before it is read: those that the
  /// triangles of a strip or fan share count once. Throws Error{UnreadableInput}.
  [[nodiscard]] std::int64_t corner_count(std::int64_t number) const;
  /// What of the file is held until all is written: itself, buffers and images beside it, what it
  /// has packed. An upper estimate. Throws Error{UnreadableInput}.
  [[nodiscard]] std::uint64_t byte_count() const;
  /// One of those, by its number. `wants_tangents`: groups with texture coordinates whose material
  /// asks for no tangents get those of the first set. `splits_normals`: instead of what the file's
  /// bytes say (FileBytes::split_normals_crease). Throws Error{UnreadableInput},
  /// Error{OutOfMemory}.
  [[nodiscard]] AssetMesh read(std::int64_t number, bool wants_tangents = false,
                               std::optional<bool> splits_normals = std::nullopt) const;
  /// Whether its nodes may get children that scale it: they neither skin, instance nor morph it.
  [[nodiscard]] bool may_be_scaled(std::int64_t number) const;

  [[nodiscard]] const JsonPlace& root() const { return root_; }
  [[nodiscard]] GltfSource& source() const { return source_; }
  [[nodiscard]] const FileBytes& file() const { return file_; }

 private:
  [[nodiscard]] AssetMesh read_unguarded(std::int64_t number, bool wants_tangents,
                                         std::optional<bool> splits_normals) const;
  // Its nodes' skins have the joints that its vertices name.
  void require_joints(std::int64_t number, const AssetVertices& vertices) const;

  FileBytes file_;
  GltfLimits limits_;
  FileFormat format_;
  std::shared_ptr<const nlohmann::json> document_;
  JsonPlace root_;
  mutable GltfSource source_;  // fetches when it is asked
  std::vector<std::int64_t> surfaces_;
};

/// The same, where the file is a glTF with at least one mesh of triangles; else null.
[[nodiscard]] std::unique_ptr<const GltfAsset> asset_of(const FileBytes& file, FileFormat format);

/// A name in an asset, and the meshes of triangles that are found by it.
struct AssetName {
  std::string name;
  std::vector<std::int64_t> meshes;
};

/// Those of meshes (where a mesh has none, its place: "meshes[3]"), of materials on triangles, and
/// of nodes with such meshes, at themselves or at nodes below them; in the file's order.
struct AssetNames {
  std::vector<AssetName> meshes, materials, nodes;
};
[[nodiscard]] AssetNames names_of(const GltfAsset& asset);

/// What is in an asset, and what becomes of it where it stays one.
struct AssetContents {
  /// How many of each list the document has: "scenes", "nodes", "materials" ...; none is left out.
  std::vector<std::pair<std::string, std::int64_t>> counts;
  std::int64_t morph_targets = 0;       ///< of all meshes
  std::vector<std::string> extensions;  ///< used, which pass; those that pack vertices aside
  std::vector<std::string> carried;     ///< attributes of triangles that are made on the surface
  std::vector<std::string> left_out;    ///< those that are not, and extensions that describe these
};

[[nodiscard]] AssetContents contents_of(const GltfAsset& asset);

/// The normal texture that a mesh's groups of one material get.
struct AssetNormalMap {
  std::span<const std::byte> png;
  int set = 0;  ///< of texture coordinates
};

/// What comes in the place of a mesh's triangles.
struct AssetSurface {
  std::int64_t mesh = 0;                    ///< its number in the asset
  const SurfaceBlocks* surface = nullptr;   ///< whose groups are those of the AssetMesh
  const AssetVertices* vertices = nullptr;  ///< of the AssetMesh
  /// A further surface of a mesh that has one is a level of detail, coarser than those before it:
  /// MSFT_lod. Of the screen, down to which this one is shown.
  double least_coverage = 0;
  /// Name, attributes, compression and extras, which asset.extras has where this is the only
  /// surface; neither origin nor turn, since nodes stay.
  GltfOptions options;
  /// Normal textures of materials, which become the mesh's own where others have them, too: by
  /// group a number of the maps, or -1; empty: materials stay as they are.
  std::vector<AssetNormalMap> normal_maps{};
  std::vector<int> map_of_group{};
};

/// The asset with surfaces instead of triangles: one primitive for each AssetGroup, with its
/// material, extras and extensions. All else stays as it is, byte by byte where it is no JSON; the
/// JSON's keys come sorted. What lies in other buffers comes into one; images beside the file come
/// into it too, unless the output is a .gltf in the same folder (`folder`: where it will stand).
/// Of `common` are taken: observe and callbacks.
/// Throws as write_gltf(), Error{UnreadableInput} where something that the asset names is not
/// there.
GltfFile write_asset(const std::filesystem::path& path, const std::filesystem::path& folder,
                     const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                     const GltfOptions& common);

/// The same as a GLB in memory.
[[nodiscard]] std::vector<std::byte> encode_asset(const GltfAsset& asset,
                                                  std::span<const AssetSurface> surfaces,
                                                  const GltfOptions& common);

}  // namespace planish
