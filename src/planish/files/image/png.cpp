#include "planish/files/image/png.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

#include "planish/core/error.h"
#include "planish/core/output_file.h"

namespace planish {
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

}  // namespace planish
