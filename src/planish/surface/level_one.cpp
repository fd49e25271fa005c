#include "planish/surface/level_one.h"

#include <string>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/surface/subdivided_mesh.h"

namespace planish {

void require_state_size(std::int64_t size, const LevelOne& level_one) {
  if (static_cast<std::int64_t>(level_one.state.size()) == size) return;
  throw Error(
      ErrorCode::InvalidArgument,
      formatted("level 1 of this mesh with these creases has {} control points, and {} are given",
                size, level_one.state.size()));
}

std::vector<glm::dvec3> limit_points(const Subdivision& subdivision,
                                     std::span<const glm::dvec3> state) {
  const auto count = static_cast<std::size_t>(subdivision.topology().vertex_count());
  std::vector<glm::dvec3> limits(count);
  parallel_for(count, 1024, [&](std::size_t begin, std::size_t end) {
    VertexRing ring;
    for (std::size_t v = begin; v < end; ++v) {
      gather_ring(subdivision, static_cast<std::int32_t>(v), ring);
      if (ring.kind == VertexKind::Corner) {
        limits[v] = state[ring.corner_point];
      } else if (ring.kind == VertexKind::Crease) {
        const VertexRing::Sector& sector = ring.sectors.front();
        limits[v] = 0.5 * (state[sector.curve0] + state[sector.curve1]);
      } else {
        // About one of the points: far from the origin the sum would lose digits.
        const glm::dvec3 origin = state[ring.faces.front()];
        glm::dvec3 sum(0.0);
        for (const std::int32_t face : ring.faces) sum += state[face] - origin;
        limits[v] = origin + sum / static_cast<double>(ring.faces.size());
      }
    }
  });
  return limits;
}

std::vector<glm::dvec3> limit_positions(const PolygonMesh& mesh, const LevelOne& level_one,
                                        const SharpFeatureOptions& sharp) {
  const SubdividedMesh base(mesh, sharp);
  require_state_size(base.subdivision.state_size(), level_one);
  const auto points = limit_points(base.subdivision, level_one.state);
  std::vector<glm::dvec3> limits = mesh.positions;
  for (std::size_t v = 0; v < points.size(); ++v) {
    limits[base.used.vertices[v]] = level_one.placement.to_model(points[v]);
  }
  return limits;
}

}  // namespace planish
