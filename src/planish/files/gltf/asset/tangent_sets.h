#pragma once

#include "planish/core/json_fwd.h"

namespace planish {

/// The set of texture coordinates whose tangents a primitive's material asks for: that of its
/// normal texture, of a clear coat's, or of what shines along a direction; -1: it asks for none.
/// Source: glTF 2.0, sections 3.7.2.1 and 3.9.3; KHR_materials_clearcoat, _anisotropy.
[[nodiscard]] int tangent_set(const nlohmann::json& document, const nlohmann::json& primitive);

/// The set that a texture of a material names, KHR_texture_transform's where it has one.
[[nodiscard]] int set_of_texture(const nlohmann::json& texture);

}  // namespace planish
