// Based on: Khronos Group, "glTF 2.0 Specification", section 4 (GLB).
#include "planish/files/gltf/glb_parts.h"

#include <cstdint>
#include <string>

#include "planish/core/error.h"
#include "planish/files/shared/bytes.h"

namespace planish {
namespace {

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

GlbParts split_glb(std::span<const std::byte> bytes, std::string_view name) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  constexpr std::uint32_t kJson = 0x4e4f534a, kBinary = 0x004e4942;
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::UnreadableInput, std::string(name) + ": " + what);
  };
  if (!text_of(bytes).starts_with("glTF")) {
    // After blanks, or a byte order mark.
    const std::size_t first = text_of(bytes).find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (first == std::string_view::npos || text_of(bytes)[first] != '{')
      fail("is no glTF: it starts neither with glTF nor with {");
    return {.json = text_of(bytes), .chunk = {}};
  }
  if (bytes.size() < kHeader + kChunkHeader)
    fail(formatted("a GLB begins with 20 bytes, but the file has {}", bytes.size()));
  const auto version = load<std::uint32_t>(bytes.subspan(4));
  if (version != 2) fail(formatted("GLB version {} is not 2", version));
  const auto length = load<std::uint32_t>(bytes.subspan(8));
  if (length > bytes.size() || length < kHeader)
    fail(formatted("header promises {} bytes, but the file has {}", length, bytes.size()));
  GlbParts parts{.json = {}, .chunk = {}, .format = FileFormat::Glb};
  std::span<const std::byte> left = bytes.subspan(kHeader, length - kHeader);
  for (int index = 0; left.size() >= kChunkHeader; ++index) {
    const auto size = load<std::uint32_t>(left);
    const auto type = load<std::uint32_t>(left.subspan(4));
    if (size > left.size() - kChunkHeader)
      fail(formatted("chunk {} promises {} bytes, but only {} follow", index, size,
                     left.size() - kChunkHeader));
    if (index == 0 && type != kJson) fail("the first chunk is not JSON");
    if (index == 0) parts.json = text_of(left.subspan(kChunkHeader, size));
    if (index == 1 && type == kBinary) parts.chunk = left.subspan(kChunkHeader, size);
    left = left.subspan(kChunkHeader + size);
  }
  return parts;
}

}  // namespace planish
