#pragma once

#include "planish/files/gltf/gltf_materials.h"
#include "planish/files/obj/material_library.h"

namespace planish {

/// The materials of a glTF as an OBJ has them: Kd and d of the base colour, Ke, Pr and Pm; map_Kd,
/// map_Ke and norm of textures that are files, with their places (-s, -o), -clamp and -bm. The
/// numbers are the glTF's, so that mtl_to_gltf.h gives them back. What MTL has no word for, and
/// images that lie in no file of their own, are left out with the warnings
/// "left-out-material-properties" and "left-out-textures".
/// Based on: Wavefront Technologies, "MTL material format (Lightwave, OBJ)", 1995; Khronos, "glTF
/// 2.0 Specification", section 3.9, KHR_texture_transform.
[[nodiscard]] MaterialLibrary library_of(const GltfMaterials& given);

}  // namespace planish
