#include "planish/mesh/hole_flags.h"

#include <string>

#include "planish/core/error.h"

namespace planish {

std::vector<std::uint8_t> hole_flags(const PolygonMesh& mesh) {
  std::vector<std::uint8_t> flags(static_cast<std::size_t>(mesh.face_count()), 0);
  for (std::size_t i = 0; i < mesh.hole_faces.size(); ++i) {
    const std::int32_t face = mesh.hole_faces[i];
    if (face < 0 || face >= mesh.face_count())
      throw Error(ErrorCode::UnusableMesh,
                  formatted("hole {} is face {} of {}", i, face, mesh.face_count()),
                  static_cast<std::int64_t>(i));
    flags[face] = 1;
  }
  return flags;
}

}  // namespace planish
