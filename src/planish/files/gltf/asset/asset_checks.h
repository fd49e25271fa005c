#pragma once

#include "planish/files/gltf/json_place.h"

namespace planish {

/// Throws Error{UnreadableInput}, naming the place, where a part of the file names another that is
/// not there (materials textures, textures images and samplers, nodes meshes, skins, cameras and
/// children, skins joints, animations nodes), and where nodes do not form trees.
void require_sound_asset(const JsonPlace& root);

}  // namespace planish
