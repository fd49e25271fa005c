#pragma once

#include <glm/vec3.hpp>

#include "planish/files/shared/file_buffer.h"

namespace planish {

/// "x y z" and a line break, as shortest round-trip text.
inline void write_position(FileBuffer& out, const glm::dvec3& position) {
  out.number(position.x).text(" ").number(position.y).text(" ").number(position.z).text("\n");
}

}  // namespace planish
