#include "planish/files/image/read_image.h"

#include <climits>
#include <memory>

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

}  // namespace planish
