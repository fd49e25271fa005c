#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planish/files/mesh_file.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

/// Writes the faces of the surface as OBJ (with `vn` and all attributes), PLY (with `nx ny nz` and
/// colours) or OFF (positions only); `header` as in MeshWriteOptions. Throws as write_mesh().
void write_surface(const std::filesystem::path& path, FileFormat format, const SurfaceMesh& surface,
                   const std::vector<std::string>& header = {});

}  // namespace planish
