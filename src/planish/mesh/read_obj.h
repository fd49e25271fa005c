#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "planish/mesh/mesh_file.h"

namespace planish {

/// Wavefront OBJ: v, f (n-gons, negative indices) and the tags `t crease` and `t corner` of
/// OpenSubdiv's shapes; lines, points and free-form elements are counted as dropped, groups,
/// materials, texture coordinates and normals are passed over. Conditions and exceptions as
/// read_mesh().
[[nodiscard]] MeshFile read_obj(std::span<const std::byte> bytes, std::string_view name);

}  // namespace planish
