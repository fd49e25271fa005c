#pragma once

#include <cstddef>

#include "planish/files/mesh_file.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

/// Geomview OFF with the prefixes ST, C and N: positions, colours (sRGB, three or four numbers from
/// 0 to 1 or from 0 to 255: see settle_colors()), texture coordinates; normals are passed over,
/// colours of faces and numbers that the keyword does not promise left out with a warning. Text has
/// a line for each vertex and face, or is read as words where it is whole so, with a warning unless
/// the file is strict. `OFF BINARY` has numbers of 32 bits, big endian, or as the counts fit,
/// with a warning. The result does not depend on `part_bytes`, of which a thread reads about so
/// many at a time of text. Conditions and exceptions as read_mesh().
[[nodiscard]] MeshFile read_off(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

}  // namespace planish
