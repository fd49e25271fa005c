#pragma once

#include <cstdint>
#include <string_view>

#include "planish/core/json_fwd.h"

namespace planish {

/// What of a primitive is no vertex: material, extras, extensions. Primitives where that is equal
/// are one on the surface.
[[nodiscard]] nlohmann::json without_vertices(const nlohmann::json& primitive);

/// 2 of "meshes[4].primitives[2]".
[[nodiscard]] std::int64_t primitive_number(std::string_view path);

/// Whether a primitive has triangles with positions, of which a surface can be made.
[[nodiscard]] bool is_surface(const nlohmann::json& primitive);

}  // namespace planish
