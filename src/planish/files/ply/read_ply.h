#pragma once

#include <cstddef>

#include "planish/files/mesh_file.h"
#include "planish/files/ply/ply_header.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

/// PLY 1.0, text or binary of either byte order: `x y z` of element `vertex` and the list
/// `vertex_indices` or `vertex_index` of element `face`, of any scalar type; triangle strips,
/// element `tristrips` with such a list in which -1 begins another strip. Vertices may have texture
/// coordinates (s t, u v, texture_u texture_v), faces a list `texcoord` of their corners'
/// coordinates, which counts before those; vertices may have colours (red green blue alpha, or
/// diffuse_red diffuse_green diffuse_blue: sRGB, integers as shares of their type's largest,
/// floating-point numbers as settle_colors() has them); all else is passed over, what faces have
/// and pictures that comments name with a warning, but for normals (nx ny nz) with
/// `split_normals_crease` and of vertices without faces. Without an element `face` the mesh has no
/// faces. Conditions and exceptions as read_mesh().
///
/// Read with a warning, unless the file is strict: values behind the last of a line, lines of the
/// header that begin with other words and look like no element or property, colours and texture
/// coordinates that are not finite, entries of text that go over lines where all numbers are as
/// many as wanted. Points without faces whose coordinates are NaN are counted and
/// left out, unless the file is strict. The result does not depend on `part_bytes`, of which a
/// thread reads about so many at a time of text.
[[nodiscard]] MeshFile read_ply(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

/// The elements behind the header of a binary file of another format, up to its end.
[[nodiscard]] MeshFile read_binary_ply_body(const FileBytes& file, const PlyHeader& header);

}  // namespace planish
