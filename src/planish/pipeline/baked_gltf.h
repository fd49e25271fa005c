#pragma once

#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/asset/write_asset.h"
#include "planish/files/gltf/gltf_materials.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/pipeline/asset_attributes.h"
#include "planish/pipeline/bake_maps.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish {

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
