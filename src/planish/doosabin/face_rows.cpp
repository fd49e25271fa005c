#include "planish/doosabin/face_rows.h"

#include "planish/core/parallel.h"
#include "planish/doosabin/vertex_ring.h"

namespace planish {

std::vector<std::int32_t> face_rows(const PolygonMesh& mesh, const QuadSplit& split, int level,
                                    const LimitRows& rows) {
  if (level == 0) {
    std::vector<std::int32_t> result = mesh.face_vertices;
    VertexRing ring;
    // The faces of Q_1 are the corners of Q_0.
    for (std::size_t corner = 0; corner < result.size(); ++corner)
      result[corner] = rows.row_of(result[corner], static_cast<std::int32_t>(corner), ring);
    return result;
  }
  const auto& topology = split.level(level);
  const auto face_count = static_cast<std::size_t>(topology.GetNumFaces());
  std::vector<std::int32_t> result(4 * face_count);
  parallel_for(face_count, 4096, [&](std::size_t begin, std::size_t end) {
    VertexRing ring;
    for (std::size_t f = begin; f < end; ++f) {
      const auto vertices = topology.GetFaceVertices(static_cast<int>(f));
      for (int k = 0; k < 4; ++k)
        result[4 * f + k] = rows.row_of(vertices[k], static_cast<std::int32_t>(f), ring);
    }
  });
  return result;
}

}  // namespace planish
