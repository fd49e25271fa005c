#pragma once

#include "planish/files/gltf/gltf_materials.h"
#include "planish/files/obj/material_library.h"

namespace planish {

/// The materials of an OBJ as glTF has them: Kd, d and Tr, Ke, Pr and Pm; roughness else by Ns as
/// Blender writes it, 1 - sqrt(Ns / 1000). Of textures map_Kd (white takes the place of Kd),
/// map_Ke, norm, map_Bump and bump, taken for normals, with their -o, -s, -clamp and -bm; PNG and
/// JPEG are embedded as they are. Others, and what is missing, are left out with the warning
/// "left-out-textures".
/// Based on: Wavefront Technologies, "MTL material format", 1995; Khronos, "glTF 2.0
/// Specification", 2021, section 3.9.
[[nodiscard]] GltfMaterials materials_of(const MaterialLibrary& library);

}  // namespace planish
