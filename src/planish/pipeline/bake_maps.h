#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/gltf_tangents.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/materials.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/asset_attributes.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/bake_normals.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// A normal texture that is to be baked: of a material on a mesh.
struct WantedMap {
  int set = 0;             ///< of texture coordinates
  NormalDetail detail{};   ///< what the material's own normal texture adds; empty: nothing
  std::string material{};  ///< its name, for messages; may be empty
};

struct BakedMap {
  std::string material;
  std::vector<std::byte> png;  ///< empty: it was left out
  int set = 0;
  NormalMap map;  ///< without its pixels
};

struct BakeMapsOptions {
  int size = 1024;
  std::vector<WantedMap> maps;
  /// By group of the mesh, one at least: its map; -1: it has none.
  std::vector<int> map_of_group;
  std::string name;     ///< what messages begin with
  Callbacks callbacks;  ///< warnings "bake-overlap", "bake-wrapped"

  /// Of each group: that of its map, or -1.
  [[nodiscard]] std::vector<int> sets() const;
};

/// Texture coordinates of each set at a level of a surface.
struct LevelUvs {
  std::vector<std::vector<glm::dvec2>> sets;
  /// `further`: values of sets from 1 on, as many as the mesh's texture coordinates.
  /// Throws Error{InvalidArgument} for further sets of a surface that knows its mesh no more.
  LevelUvs(const SurfaceBlocks& surface, std::span<const std::vector<glm::dvec2>> further);
  [[nodiscard]] TangentSource tangents(std::span<const int> set_of_group) const;
};

/// The level whose facets are about as large as texels of a map of that size, and no more of them
/// than kMostBakedFaces.
[[nodiscard]] int bake_level(const PolygonMesh& mesh, int size);
inline constexpr std::int64_t kMostBakedFaces = std::int64_t{1} << 22;

/// Bytes that bake_maps() takes beside its maps, at most, for so many faces of both levels
/// together.
[[nodiscard]] std::uint64_t bake_bytes(std::int64_t face_count, int size);

/// Takes the map from groups of it some of whose faces have no texture coordinates, with the
/// warning "bake-left-out". Throws Error{UnusableMesh} where none is left.
void settle_maps(const PolygonMesh& mesh, BakeMapsOptions& options);

/// The maps, in order: `low`, level 0 of a mesh's surface as write_gltf() writes it with these
/// tangents, looks with them as `fine`, another level, does. `further`: values of sets of texture
/// coordinates from 1 on, as many as those of the mesh. `options` are settled. Throws
/// Error{UnusableMesh} where a texture repeats or has no area, Error{OutOfMemory},
/// Error{Cancelled}.
[[nodiscard]] std::vector<BakedMap> bake_maps(const PolygonMesh& mesh, const SurfaceBlocks& low,
                                              const SurfaceTangents& low_tangents,
                                              const SurfaceBlocks& fine,
                                              std::span<const std::vector<glm::dvec2>> further,
                                              const BakeMapsOptions& options);

struct BakeFileOptions {
  int size = 1024;            ///< texels along a side of each map
  bool double_sided = false;  ///< materials of a surface that nothing else is known of
  std::string name;           ///< what messages begin with
  Callbacks callbacks;        ///< those of bake_maps(), "bake-unread-texture"
};

/// Level 0 of a mesh's surface with a normal texture for each of its materials, by which it looks
/// as the surface does. Materials of the same name have one. Those that have a normal texture keep
/// what it shows: it lies on the surface.
class BakedSurface {
 public:
  /// `low`, `fine`: levels of the fitted mesh, see bake_level(). Throws as bake_maps().
  BakedSurface(const FittedMesh& fitted, const SurfaceBlocks& low, const SurfaceBlocks& fine,
               const GltfMaterials& materials, const BakeFileOptions& options);

  /// Of `low`; this must outlive them.
  void add_to(GltfOptions& options) const;
  [[nodiscard]] std::span<const BakedMap> maps() const { return maps_; }

 private:
  SurfaceTangents tangents_;
  std::vector<std::uint8_t> in_groups_;
  std::vector<BakedMap> maps_;
  GltfMaterials materials_;
};

/// The same of a mesh of an asset that was read with tangents. One that gets no map stays without.
class BakedAssetMesh {
 public:
  /// `attributes`: of `low`. Throws Error{OutOfMemory}, Error{Cancelled}.
  BakedAssetMesh(const GltfAsset& asset, const AssetMesh& mesh, const FittedMesh& fitted,
                 const SurfaceBlocks& low, const AssetAttributes& attributes,
                 const SurfaceBlocks& fine, const BakeFileOptions& options);

  /// Of `low`; this must outlive it.
  void add_to(AssetSurface& surface) const;
  [[nodiscard]] std::span<const BakedMap> maps() const { return maps_; }
  /// Why there are none; empty: there are.
  [[nodiscard]] const std::string& why_none() const { return why_none_; }

 private:
  std::vector<BakedMap> maps_;
  std::vector<int> map_of_group_;
  std::string why_none_;
};

}  // namespace planish
