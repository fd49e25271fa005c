#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "planish/files/shared/split_normals.h"

namespace planish {

/// The normals of an OBJ file that read_obj() has read: `vn` lines, and what `v/vt/vn` says of
/// them. Numbers that are none make no normal. Throws Error{UnreadableInput} for an index that
/// names none.
[[nodiscard]] CornerNormals read_obj_normals(std::span<const std::byte> bytes,
                                             std::string_view name);

}  // namespace planish
