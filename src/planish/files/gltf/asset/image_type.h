#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "planish/files/gltf/asset/gltf_asset.h"

namespace planish {

/// The media type of an image by its first bytes, else by the extension of its name:
/// "image/png". "application/octet-stream" where neither tells.
[[nodiscard]] std::string image_type(std::span<const std::byte> bytes, std::string_view name);

/// An image of an asset.
struct AssetImage {
  std::span<const std::byte> bytes;  ///< as long as the asset lives
  std::string type;                  ///< "image/png"
  std::string missing;               ///< why its file cannot be read; empty: these are its bytes
};

/// Image `number`. One whose file cannot be read is a pixel that changes nothing about a material:
/// white, or flat where it is a texture of normals, so that no number in the document changes.
/// Throws Error{UnreadableInput} where its bytes ought to stand in the asset itself.
[[nodiscard]] AssetImage asset_image(const GltfAsset& asset, std::int64_t number);

/// The warning of images that are missing, by AssetImage::missing of each; there is at least one.
[[nodiscard]] Warning missing_images(std::span<const std::string> why);

}  // namespace planish
