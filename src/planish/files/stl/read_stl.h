#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "planish/files/mesh_file.h"

namespace planish {

/// STL, text or binary (recognised by its size of 84 + 50 n bytes), welded by exact position;
/// triangles without area are left out with a warning. Conditions and exceptions as read_mesh().
[[nodiscard]] MeshFile read_stl(std::span<const std::byte> bytes, std::string_view name);

}  // namespace planish
