#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/json_fwd.h"
#include "planish/files/gltf/asset/gltf_asset.h"

namespace planish {

/// 8-bit RGB, top row first.
struct RgbImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;

  [[nodiscard]] const std::uint8_t* at(int x, int y) const {
    return pixels.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                static_cast<std::size_t>(x));
  }
};

/// The largest image that is read, in pixels along a side: what the largest texture of a device is.
inline constexpr int kMostImageSide = 16384;

/// A PNG or a JPEG, of any depth; grey becomes RGB, alpha is left out. Empty where it is neither,
/// is damaged, or has a side above kMostImageSide: its size is looked at before memory is taken.
[[nodiscard]] std::optional<RgbImage> read_image(std::span<const std::byte> bytes);

/// 8-bit rows, top row first, of `channels` bytes a pixel (3: RGB, 4: with alpha, not multiplied),
/// as PNG. Throws Error{OutOfMemory}.
[[nodiscard]] std::vector<std::byte> png_of(int width, int channels,
                                            std::span<const std::uint8_t> pixels);

/// RGB, as a file that appears whole or not at all. Throws Error{UnwritableOutput},
/// Error{OutOfMemory}.
void write_png(const std::filesystem::path& path, int width, std::span<const std::uint8_t> pixels);

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

/// The image of a material's normal texture, by its number; -1: it has none, or none but in a
/// format of an extension. `lists`: a document, or GltfMaterials::lists.
[[nodiscard]] std::int64_t normal_image(const nlohmann::json& lists,
                                        const nlohmann::json& material);

/// A material's normal texture, to be read at any place: with its scale, KHR_texture_transform, and
/// how its sampler wraps; between texels it is linear.
class NormalTexture {
 public:
  /// `material` has one.
  NormalTexture(RgbImage image, const nlohmann::json& lists, const nlohmann::json& material);

  /// x to the right, y upwards, z outwards; unit. `uv`: v runs upwards.
  [[nodiscard]] glm::dvec3 at(const glm::dvec2& uv) const;

 private:
  RgbImage image_;
  double scale_ = 1, rotation_ = 0;
  glm::dvec2 offset_{0.0}, stretch_{1.0};
  std::array<int, 2> wraps_;
};

/// Gives a material the normal texture of an image, in its coordinates of that set, in the place of
/// what it has; and to a clear coat that has none of its own. The texture is added to `lists`.
void set_normal_texture(nlohmann::json& lists, nlohmann::json& material, std::int64_t image,
                        int set);

}  // namespace planish
