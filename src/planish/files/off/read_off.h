#pragma once

#include <cstddef>

#include "planish/files/mesh_file.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

/// Geomview OFF, text or `OFF BINARY` (numbers of 32 bits, big endian), with the prefixes ST, C and
/// N; what stands after the position of a vertex or the indices of a face is passed over. The
/// result does not depend on `part_bytes`, of which a thread reads about so many at a time of text.
/// Conditions and exceptions as read_mesh().
[[nodiscard]] MeshFile read_off(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

}  // namespace planish
