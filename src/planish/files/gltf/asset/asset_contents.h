#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "planish/files/gltf/asset/gltf_asset.h"

namespace planish {

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

}  // namespace planish
