#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "planish/files/mesh_file.h"

namespace planish {

/// Geomview OFF as text, with the prefixes ST, C and N; what stands after the position of a vertex
/// or the indices of a face is passed over. Conditions and exceptions as read_mesh().
[[nodiscard]] MeshFile read_off(std::span<const std::byte> bytes, std::string_view name);

/// The same in parts of about `part_bytes`, on which the result does not depend; threads take one
/// part at a time.
[[nodiscard]] MeshFile read_off_in_parts(std::span<const std::byte> bytes, std::string_view name,
                                         std::size_t part_bytes);

}  // namespace planish
