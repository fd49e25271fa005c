#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/json_place.h"

namespace planish {

/// The extension of a buffer view whose bytes are packed.
inline constexpr const char* kMeshoptExtension = "EXT_meshopt_compression";

/// Unpacks `stream` as `extension`, the EXT_meshopt_compression object of a buffer view, says:
/// count * byteStride bytes. Sizes are held against the most that so many bytes can stand for
/// before memory is taken. Throws Error{UnreadableInput}.
[[nodiscard]] RawVector<std::byte> decode_meshopt(const JsonPlace& extension,
                                                  std::span<const std::byte> stream);

}  // namespace planish
