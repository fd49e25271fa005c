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

/// The set of texture coordinates whose tangents a primitive's material asks for: that of its
/// normal texture, of a clear coat's, or of what shines along a direction; -1: it asks for none.
/// Source: glTF 2.0, sections 3.7.2.1 and 3.9.3; KHR_materials_clearcoat, _anisotropy.
[[nodiscard]] int tangent_set(const nlohmann::json& document, const nlohmann::json& primitive);

/// The set that a texture of a material names, KHR_texture_transform's where it has one.
[[nodiscard]] int set_of_texture(const nlohmann::json& texture);

}  // namespace planish
