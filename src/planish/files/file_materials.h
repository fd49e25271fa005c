#pragma once

#include "planish/core/callbacks.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/gltf_materials.h"
#include "planish/files/obj/material_library.h"

namespace planish {

/// What a file says of the materials that its groups name.
struct FileMaterials {
  MaterialLibrary library;  ///< of an OBJ or a glTF, for an OBJ
  GltfMaterials gltf;       ///< of an OBJ or a glTF, for a glTF or USD

  [[nodiscard]] std::vector<Warning> warnings() const;
};

/// Reads them where the mesh of `file` becomes an OBJ, or a glTF or USD that holds it alone. What
/// is wrong or missing is a warning, "missing-materials", and "left-out-textures": the shape is
/// there.
[[nodiscard]] FileMaterials read_materials(const FileBytes& file, FileFormat format, bool to_obj,
                                           bool to_gltf);

}  // namespace planish
