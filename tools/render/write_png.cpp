#include "write_png.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

#include "planish/core/error.h"
#include "planish/core/output_file.h"

namespace planish::render {

void write_png(const std::filesystem::path& path, int width, std::span<const std::uint8_t> pixels) {
  OutputFile file(path);
  const auto send = [](void* context, void* data, int size) {
    static_cast<OutputFile*>(context)->write(
        std::span(static_cast<const std::byte*>(data), static_cast<std::size_t>(size)));
  };
  constexpr int kChannels = 3;
  const int row_bytes = kChannels * width;
  const int height = static_cast<int>(pixels.size() / static_cast<std::size_t>(row_bytes));
  stbi_write_png_compression_level = 9;
  if (!stbi_write_png_to_func(send, &file, width, height, kChannels, pixels.data(), row_bytes)) {
    throw Error(ErrorCode::OutOfMemory, path.string() + ": no memory for the PNG");
  }
  file.commit();
}

}  // namespace planish::render
