#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "planish/files/mesh_file.h"
#include "planish/surface/surface_mesh.h"
#include "planish/surface/vertex_fields.h"

namespace planish {

/// Writes the faces of the surface as OBJ (with `vn` and all attributes), PLY (with `nx ny nz` and
/// colours), OFF (positions only), STL (triangles) or USD text (all attributes); `header` as in
/// MeshWriteOptions. Fields become float properties of their names in PLY and USD, and are left out
/// of the others. Throws as write_mesh().
void write_surface(const std::filesystem::path& path, FileFormat format, const SurfaceMesh& surface,
                   const std::vector<std::string>& header = {},
                   std::span<const NamedField> fields = {});

}  // namespace planish
