#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/json.h"
#include "planish/core/raw_vector.h"
#include "planish/files/gltf/asset/gltf_asset.h"

namespace planish {

struct GltfDocument;  // gltf_document.h

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

}  // namespace planish
