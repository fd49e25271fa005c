#include "planish/files/gltf/asset/image_type.h"

#include <algorithm>

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

}  // namespace planish
