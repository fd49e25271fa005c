#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/gltf/gltf_materials.h"

namespace planish {

/// Materials as prims of USD.
struct UsdMaterials {
  std::string text;                          ///< the prims within the scope `kUsdMaterials`
  std::map<std::string, std::string> paths;  ///< by a group's material
  std::vector<Warning> warnings;
};

inline constexpr const char* kUsdMaterials = "/surface/materials";

/// Those of `given` that `names` name: UsdPreviewSurface with base colour, opacity, metallic,
/// roughness, emission, normal and occlusion; their textures as UsdUVTexture, with their places, of
/// files that are named as seen from `folder`. Images that lie in no file of their own, and files
/// that USD cannot name, are left out with the warning "left-out-textures".
/// Based on: Pixar, "UsdPreviewSurface Specification", 2.6; Khronos, "glTF 2.0 Specification",
/// section 3.9, KHR_texture_transform.
[[nodiscard]] UsdMaterials usd_materials(const GltfMaterials& given,
                                         std::span<const std::string> names,
                                         const std::filesystem::path& folder);

}  // namespace planish
