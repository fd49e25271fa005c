#pragma once

#include "planish/files/gltf/gltf_budget.h"
#include "planish/files/mesh_file.h"

namespace planish {

/// Reads a .glb or .gltf file: the triangles of the default scene (scene 0 where none is named)
/// with all node transforms applied, of skinned meshes those of their joints, welded by position
/// across primitives; what KHR_node_visibility hides is left out. Texture
/// coordinates (TEXCOORD_0) stay with the corners, colours (COLOR_0) with the vertices, material
/// names become groups. External buffers are read from beside the file only; absolute and parent
/// paths are refused.
/// Without a path buffers must be embedded (GLB chunk or data URI).
/// Throws Error{UnreadableInput}: what is out of range, its JSON path and value;
/// Error{OutOfMemory} for a scene that needs more than the machine has free.
[[nodiscard]] MeshFile read_gltf(const FileBytes& file);

/// The same within other limits.
[[nodiscard]] MeshFile read_gltf_within(const FileBytes& file, const GltfLimits& limits);

}  // namespace planish
