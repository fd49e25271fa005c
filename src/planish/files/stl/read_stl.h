#pragma once

#include <cstddef>

#include "planish/files/mesh_file.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

/// STL, text or binary (recognised by its size of 84 + 50 n bytes), welded by position, at open
/// edges within two steps of float32 where that closes them, with a warning; triangles without area
/// are left out with a warning, colours too, and, unless the file is strict, lines of other words
/// outside facets and zeros behind a binary file's triangles. The result does not depend on
/// `part_bytes`, of which a thread reads about so many at a time of text. Conditions and exceptions
/// as read_mesh().
[[nodiscard]] MeshFile read_stl(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

}  // namespace planish
