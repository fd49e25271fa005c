#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "planish/files/mesh_file.h"

namespace planish {

/// PLY 1.0, text or binary of either byte order: `x y z` of element `vertex` and the list
/// `vertex_indices` or `vertex_index` of element `face`, of any scalar type. Vertices may have
/// texture coordinates (s t, u v, texture_u texture_v) and colours (red green blue alpha: integers
/// are sRGB by convention, floating-point numbers linear; clamped to their range); all else is
/// passed over, but for normals (nx ny nz) with `split_normals_crease` and of vertices without
/// faces. Without an element `face` the mesh has no faces. Conditions and exceptions as
/// read_mesh().
[[nodiscard]] MeshFile read_ply(const FileBytes& file);
[[nodiscard]] MeshFile read_ply(std::span<const std::byte> bytes, std::string_view name);

/// The same, text in parts of about `part_bytes`, on which the result does not depend; threads take
/// one part at a time.
[[nodiscard]] MeshFile read_ply_in_parts(std::span<const std::byte> bytes, std::string_view name,
                                         std::size_t part_bytes);

}  // namespace planish
