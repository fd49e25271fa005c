#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

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
