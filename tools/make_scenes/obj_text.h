#pragma once

#include <string>
#include <string_view>

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

/// The mesh as Wavefront OBJ: `# comment`, then vertices, faces with their attributes, and
/// `t crease` / `t corner` / `t hole` tags as OpenSubdiv reads them. Numbers are shortest
/// round-trip doubles, so equal meshes give equal bytes.
[[nodiscard]] std::string obj_text(const PolygonMesh& mesh, std::string_view comment);

}  // namespace planish::shapes
