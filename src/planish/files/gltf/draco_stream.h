#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/json_place.h"

namespace planish {

/// The extension of a primitive whose corners and attributes are packed.
inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

/// Elements that stood packed, one behind the other.
struct UnpackedElements {
  std::int64_t count = 0, number_count = 0;  ///< elements, numbers of each
  std::int64_t component = 0;                ///< componentType of an accessor that holds them
  RawVector<std::byte> bytes;
};

/// What a Draco stream holds.
struct DracoMesh {
  UnpackedElements corners;                                ///< three of each triangle, in 32 bits
  std::map<std::int64_t, UnpackedElements> by_identifier;  ///< attributes, each with point_count
};

/// How much a stream must hold: what the accessors say.
struct DracoCounts {
  std::int64_t corner_count, point_count;
};

/// False: files that require the extension are refused.
[[nodiscard]] bool reads_draco();

/// Unpacks a mesh of Draco's bitstream 2.2. Its counts must be `wanted`, and no larger than so many
/// bytes may stand for, before memory is taken. `extension` stands in messages. Throws
/// Error{UnreadableInput}.
[[nodiscard]] DracoMesh decode_draco(const JsonPlace& extension, std::span<const std::byte> stream,
                                     const DracoCounts& wanted);

}  // namespace planish
