#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/json.h"
#include "planish/core/raw_vector.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/obj/material_library.h"

namespace planish {

struct GltfDocument;  // gltf_payload.h

/// Text with U+FFFD where it is no UTF-8: glTF is UTF-8, tinygltf and JSON throw else.
[[nodiscard]] std::string valid_utf8(const std::string& text);

/// An image as it stands in a file.
struct GltfImage {
  std::string type;  ///< "image/png"
  RawVector<std::byte> bytes;
  std::filesystem::path path{};  ///< the file that it is; empty: it lies in another
};

/// Materials for the groups of a surface whose names they have, with all that they name.
struct GltfMaterials {
  /// Lists of a glTF document: "materials", each of a name of its own; "textures", "samplers",
  /// "images", of which nothing says where their bytes are; "extensionsUsed",
  /// "extensionsRequired".
  nlohmann::json lists = nlohmann::json::object();
  std::vector<GltfImage> images;  ///< one for each of the list
  bool has_sides = true;  ///< false: "doubleSided" is that of the material whose place they take
  std::vector<Warning> warnings;
  std::filesystem::path input{};  ///< the file that they are of: nothing is written over it

  /// The base colour of the material of that name, in any bytes, as displays have it (sRGB), each 0
  /// to 1; empty: there is none, or nothing says its colour.
  [[nodiscard]] std::optional<glm::dvec3> display_color(std::string_view name) const;
  /// Puts them in the place of a document's materials of these names, if it has any. Its images are
  /// found by `folder`, as image_name() has them; where that is empty they come into the buffer.
  /// This must outlive it.
  void apply(GltfDocument& document, std::string_view folder) const;
  /// "3.png" of image 3.
  [[nodiscard]] std::string image_name(std::size_t image) const;
};

/// The names that a document's materials have in meshes that are read from it: their own, of those
/// without one and of those whose name another has already "material_2", by their number.
[[nodiscard]] std::vector<std::string> material_names(const JsonPlace& root);

/// Of a glTF. A mesh that is read from all of its scene has one set of texture coordinates:
/// textures of others are left out, with the warning "left-out-textures". Throws
/// Error{UnreadableInput}.
[[nodiscard]] GltfMaterials materials_of(const GltfAsset& asset);

/// The materials of a glTF as an OBJ has them: Kd and d of the base colour, Ke, Pr and Pm; map_Kd,
/// map_Ke and norm of textures that are files, with their places (-s, -o), -clamp and -bm. The
/// numbers are the glTF's, so that materials.h gives them back. What MTL has no word for, and
/// images that lie in no file of their own, are left out with the warnings
/// "left-out-material-properties" and "left-out-textures".
/// Based on: Wavefront Technologies, "MTL material format (Lightwave, OBJ)", 1995; Khronos, "glTF
/// 2.0 Specification", section 3.9, KHR_texture_transform.
[[nodiscard]] MaterialLibrary library_of(const GltfMaterials& given);

/// The materials of an OBJ as glTF has them: Kd, d and Tr, Ke, Pr and Pm; roughness else by Ns as
/// Blender writes it, 1 - sqrt(Ns / 1000). Of textures map_Kd (white takes the place of Kd),
/// map_Ke, norm, map_Bump and bump, taken for normals, with their -o, -s, -clamp and -bm; PNG and
/// JPEG are embedded as they are. Others, and what is missing, are left out with the warning
/// "left-out-textures".
/// Based on: Wavefront Technologies, "MTL material format", 1995; Khronos, "glTF 2.0
/// Specification", 2021, section 3.9.
[[nodiscard]] GltfMaterials materials_of(const MaterialLibrary& library);

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

/// What a file says of the materials that its groups name.
struct FileMaterials {
  MaterialLibrary library;  ///< of an OBJ or a glTF, for an OBJ
  GltfMaterials gltf;       ///< of an OBJ or a glTF, for a glTF or USD

  [[nodiscard]] std::vector<Warning> warnings() const;
};

/// Reads them where the mesh of `file` becomes an OBJ, or a glTF or USD that holds it alone. What
/// is wrong or missing is a warning, "missing-materials", and "left-out-textures": the shape is
/// there.
[[nodiscard]] FileMaterials read_materials(const FileBytes& file, FileFormat format, bool to_obj,
                                           bool to_gltf);

}  // namespace planish
