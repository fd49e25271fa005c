#pragma once

#include "planish/files/mesh_file.h"

namespace planish {

/// Reads a .glb or .gltf file: the triangles of the default scene (scene 0 where none is named)
/// with all node transforms applied, welded by exact position across primitives. Texture
/// coordinates (TEXCOORD_0) stay with the corners, colours (COLOR_0) with the vertices, material
/// names become groups. External buffers are read from beside the file only; absolute and parent
/// paths are refused.
/// Without a path buffers must be embedded (GLB chunk or data URI).
/// Throws Error{UnreadableInput}: what is out of range, its JSON path and value.
[[nodiscard]] MeshFile read_gltf(const FileBytes& file);

}  // namespace planish
