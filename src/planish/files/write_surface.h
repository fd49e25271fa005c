#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/mesh_file.h"
#include "planish/measure/vertex_fields.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Writes the faces of the surface as OBJ (with `vn` and all attributes), PLY (with `nx ny nz` and
/// colours), OFF (positions only), STL (triangles) or USD text (all attributes); `header` as in
/// MeshWriteOptions. Fields become float properties of their names in PLY and USD, and are left out
/// of the others. Throws as write_mesh().
void write_surface(const std::filesystem::path& path, FileFormat format, const SurfaceMesh& surface,
                   const std::vector<std::string>& header = {},
                   std::span<const NamedField> fields = {});

struct SurfaceWriteOptions {
  std::vector<std::string> header;
  std::span<const NamedField> fields;
  bool is_z_up = false;      ///< of USD
  GivenMaterials materials;  ///< of OBJ and USD
  /// Gets all bytes in order while they are written: for a digest.
  std::function<void(std::span<const std::byte>)> observe;
  Callbacks callbacks;  ///< step "write", warnings "degenerate-normals" and "lost-attributes"
};

/// The same of a surface that is made as it is written, which nobody holds: the same bytes, in the
/// memory of a few pieces, and 12 bytes a row for STL. Returns their number.
std::uint64_t write_surface(const std::filesystem::path& path, FileFormat format,
                            const SurfaceBlocks& surface, const SurfaceWriteOptions& options);

}  // namespace planish
