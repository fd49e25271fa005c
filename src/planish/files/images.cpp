#include "planish/files/images.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/files/gltf/gltf_json.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_JPEG
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 16384  // kMostImageSide
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

namespace planish {

static_assert(STBI_MAX_DIMENSIONS == kMostImageSide);

std::optional<RgbImage> read_image(std::span<const std::byte> bytes) {
  if (bytes.size() > INT_MAX) return std::nullopt;
  const auto* from = reinterpret_cast<const stbi_uc*>(bytes.data());
  const auto size = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(from, size, &width, &height, &channels) || width > kMostImageSide ||
      height > kMostImageSide)
    return std::nullopt;
  const std::unique_ptr<stbi_uc, void (*)(void*)> made(
      stbi_load_from_memory(from, size, &width, &height, &channels, 3), stbi_image_free);
  if (!made) return std::nullopt;
  RgbImage image{width, height, {}};
  image.pixels.assign(made.get(), made.get() + std::size_t{3} * static_cast<std::size_t>(width) *
                                                   static_cast<std::size_t>(height));
  return image;
}

namespace {

// Set once: files are written on several threads.
[[maybe_unused]] const bool kIsPackedWell = (stbi_write_png_compression_level = 9, true);

}  // namespace

std::vector<std::byte> png_of(int width, int channels, std::span<const std::uint8_t> pixels) {
  std::vector<std::byte> bytes;
  const auto take = [](void* context, void* data, int size) {
    const auto* first = static_cast<const std::byte*>(data);
    auto& all = *static_cast<std::vector<std::byte>*>(context);
    all.insert(all.end(), first, first + size);
  };
  const int row_bytes = channels * width;
  const int height = static_cast<int>(pixels.size() / static_cast<std::size_t>(row_bytes));
  if (!stbi_write_png_to_func(take, &bytes, width, height, channels, pixels.data(), row_bytes))
    throw Error(ErrorCode::OutOfMemory, "no memory for a PNG");
  return bytes;
}

void write_png(const std::filesystem::path& path, int width, std::span<const std::uint8_t> pixels) {
  const std::vector<std::byte> bytes = png_of(width, 3, pixels);
  OutputFile file(path);
  file.write(bytes);
  file.commit();
}

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

namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.8 (textures, samplers) and 3.9.3
// (normal textures); KHR_texture_transform; KHR_materials_clearcoat.

constexpr int kMirroredRepeat = 33648, kRepeat = 10497;

// Of a texel outside of an image, the one inside that stands for it.
int wrapped(std::int64_t texel, int size, int wrap) {
  if (wrap == kClampToEdge) return static_cast<int>(std::clamp<std::int64_t>(texel, 0, size - 1));
  const std::int64_t period = wrap == kMirroredRepeat ? 2 * std::int64_t{size} : size;
  const std::int64_t inside = ((texel % period) + period) % period;
  return static_cast<int>(inside < size ? inside : period - 1 - inside);
}

const json& normal_texture_of(const json& lists, const json& material) {
  return json_at(lists, "textures", json_at(json_at(material, "normalTexture"), "index"));
}

}  // namespace

std::int64_t normal_image(const json& lists, const json& material) {
  const json& source = json_at(normal_texture_of(lists, material), "source");
  return source.is_number_integer() ? source.get<std::int64_t>() : -1;
}

NormalTexture::NormalTexture(RgbImage image, const json& lists, const json& material)
    : image_(std::move(image)), wraps_{kRepeat, kRepeat} {
  const json& info = json_at(material, "normalTexture");
  scale_ = number_at(json_at(info, "scale"), 1);
  const json& moved = json_at(json_at(info, "extensions"), "KHR_texture_transform");
  rotation_ = number_at(json_at(moved, "rotation"), 0);
  const JsonNumbers offset = values_of(json_at(moved, "offset"), {0, 0});
  const JsonNumbers stretch = values_of(json_at(moved, "scale"), {1, 1});
  offset_ = {offset[0], offset[1]};
  stretch_ = {stretch[0], stretch[1]};
  const json& sampler =
      json_at(lists, "samplers", json_at(normal_texture_of(lists, material), "sampler"));
  wraps_[0] = static_cast<int>(number_at(json_at(sampler, "wrapS"), kRepeat));
  wraps_[1] = static_cast<int>(number_at(json_at(sampler, "wrapT"), kRepeat));
}

glm::dvec3 NormalTexture::at(const glm::dvec2& uv) const {
  const glm::dvec2 given(uv.x * stretch_.x, (1 - uv.y) * stretch_.y);
  const double c = portable::cos(rotation_), s = portable::sin(rotation_);
  const glm::dvec2 place(c * given.x + s * given.y + offset_.x,
                         c * given.y - s * given.x + offset_.y);
  // Farther, texels of a texture that repeats are told apart no more.
  constexpr double kFarthest = 1e15;
  const auto texels_of = [&](double coordinate, int size) {
    return std::clamp(coordinate * size - 0.5, -kFarthest, kFarthest);
  };
  const double x = texels_of(place.x, image_.width), y = texels_of(place.y, image_.height);
  const double left = std::floor(x), top = std::floor(y);
  glm::dvec3 sum(0.0);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const double weight =
          (i == 0 ? 1 - (x - left) : x - left) * (j == 0 ? 1 - (y - top) : y - top);
      const std::uint8_t* texel =
          image_.at(wrapped(static_cast<std::int64_t>(left) + i, image_.width, wraps_[0]),
                    wrapped(static_cast<std::int64_t>(top) + j, image_.height, wraps_[1]));
      sum += weight * (glm::dvec3(texel[0], texel[1], texel[2]) / 127.5 - 1.0);
    }
  return unit_or_zero({scale_ * sum.x, scale_ * sum.y, sum.z});
}

void set_normal_texture(json& lists, json& material, std::int64_t image, int set) {
  json& textures = lists["textures"];
  json texture{{"index", textures.size()}};
  if (set > 0) texture["texCoord"] = set;
  textures.push_back({{"source", image}});
  material["normalTexture"] = texture;
  if (const auto extensions = material.find("extensions"); extensions != material.end())
    if (const auto coat = extensions->find("KHR_materials_clearcoat"); coat != extensions->end())
      coat->emplace("clearcoatNormalTexture", texture);
}

}  // namespace planish
