#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "planish/files/formats.h"

namespace planish {

/// A glTF file's document, and a GLB's binary chunk.
struct GlbParts {
  std::string_view json;
  std::span<const std::byte> chunk;
  FileFormat format = FileFormat::Gltf;
};

/// Takes a GLB apart; other files are all document. Throws Error{UnreadableInput}.
[[nodiscard]] GlbParts split_glb(std::span<const std::byte> bytes, std::string_view name);

}  // namespace planish
