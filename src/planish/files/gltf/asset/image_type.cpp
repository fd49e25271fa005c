#include "planish/files/gltf/asset/image_type.h"

#include <algorithm>
#include <array>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/lower_case.h"

namespace planish {
namespace {

struct ImageFormat {
  std::string_view start, type, extension;
};

constexpr ImageFormat kImageFormats[] = {{"\x89PNG\r\n", "image/png", ".png"},
                                         {"\xFF\xD8\xFF", "image/jpeg", ".jpg"},
                                         {"\xFF\xD8\xFF", "image/jpeg", ".jpeg"},
                                         {"\xABKTX 20\xBB", "image/ktx2", ".ktx2"},
                                         {"DDS ", "image/vnd-ms.dds", ".dds"},
                                         {"RIFF", "image/webp", ".webp"},
                                         {"", "image/avif", ".avif"}};

using nlohmann::json;

// PNG files of one pixel: (255, 255, 255), and (128, 128, 255), the normal that leans nowhere.
constexpr std::array<unsigned char, 69> kWhitePixel = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
    0x44, 0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00,
    0x00, 0x90, 0x77, 0x53, 0xde, 0x00, 0x00, 0x00, 0x0c, 0x49, 0x44, 0x41, 0x54, 0x78,
    0xda, 0x63, 0xf8, 0xff, 0xff, 0x3f, 0x00, 0x05, 0xfe, 0x02, 0xfe, 0x33, 0x12, 0x95,
    0x14, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82,
};
constexpr std::array<unsigned char, 69> kFlatPixel = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
    0x44, 0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00,
    0x00, 0x90, 0x77, 0x53, 0xde, 0x00, 0x00, 0x00, 0x0c, 0x49, 0x44, 0x41, 0x54, 0x78,
    0xda, 0x63, 0x68, 0x68, 0xf8, 0x0f, 0x00, 0x03, 0x83, 0x02, 0x00, 0x3e, 0x58, 0x28,
    0x25, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82,
};

// Whether a texture of the document shows an image, by itself or by an extension (WebP, KTX2).
bool shows(const json& texture, std::int64_t image) {
  if (texture.contains("source") && texture["source"] == image) return true;
  if (!texture.contains("extensions")) return false;
  return std::ranges::any_of(texture["extensions"], [&](const json& extension) {
    return extension.is_object() && extension.contains("source") && extension["source"] == image;
  });
}

// Whether anything in a material, or in an extension of it, takes normals out of an image.
bool has_normals_in(const json& document, const json& place, std::int64_t image) {
  if (!place.is_object()) return false;
  for (const auto& [key, member] : place.items()) {
    const bool is_of_normals = lower_case(key).ends_with("normaltexture");
    if (is_of_normals && member.is_object() && member.contains("index") &&
        shows(document.at("textures").at(member["index"].get<std::size_t>()), image))
      return true;
    if (has_normals_in(document, member, image)) return true;
  }
  return false;
}

bool is_of_normals(const json& document, std::int64_t image) {
  return document.contains("materials") &&
         std::ranges::any_of(document["materials"], [&](const json& material) {
           return has_normals_in(document, material, image);
         });
}

// "image/avif" of "data:image/avif;base64,...".
std::string_view type_in(std::string_view data_uri) {
  const std::string_view head = data_uri.substr(0, data_uri.find_first_of(";,"));
  return head.substr(head.find(':') + 1);
}

}  // namespace

std::string image_type(std::span<const std::byte> bytes, std::string_view name) {
  const std::string_view start(reinterpret_cast<const char*>(bytes.data()),
                               std::min<std::size_t>(bytes.size(), 16));
  for (const ImageFormat& format : kImageFormats)
    if (!format.start.empty() && start.starts_with(format.start)) return std::string(format.type);
  const std::string lower = lower_case(name);
  for (const ImageFormat& format : kImageFormats)
    if (lower.ends_with(format.extension)) return std::string(format.type);
  return "application/octet-stream";
}

AssetImage asset_image(const GltfAsset& asset, std::int64_t number) {
  const JsonPlace place = asset.root()["images"][number];
  const auto uri = place.find("uri");
  AssetImage image;
  if (!uri || is_data_uri(uri->text())) {
    image.bytes =
        uri ? asset.source().fetch(*uri) : asset.source().view(place["bufferView"].integer());
    image.type = image_type(image.bytes, "");
    const std::string_view said = uri ? type_in(uri->text()) : "";
    if (!image.type.starts_with("image/") && said.starts_with("image/")) image.type = said;
    return image;
  }
  try {
    image.bytes = asset.source().fetch(*uri);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;
    image.missing = error.what();
    image.bytes = is_of_normals(asset.root().value(), number)
                      ? std::as_bytes(std::span(kFlatPixel))
                      : std::as_bytes(std::span(kWhitePixel));
  }
  image.type = image_type(image.bytes, uri->text());
  return image;
}

Warning missing_images(std::span<const std::string> why) {
  return {"missing-images",
          formatted("{}{}; materials are as without {}", why.front(),
                    why.size() > 1 ? formatted(", and {} more images", why.size() - 1) : "",
                    why.size() > 1 ? "them" : "it"),
          std::ssize(why)};
}

}  // namespace planish
