#include "planish/primal/vertex_star.h"

#include <algorithm>

#include "planish/core/assert.h"

namespace planish {

namespace {

bool is_infinite(float sharpness) { return sharpness >= kInfiniteSharpness; }

// Where the first sector begins: at the first sharp edge.
std::int32_t first_sharp_edge(const VertexStar& star) {
  const auto found = std::ranges::find_if(star.edge_sharpness, is_infinite);
  PLANISH_ASSERT(found != star.edge_sharpness.end());
  return static_cast<std::int32_t>(found - star.edge_sharpness.begin());
}

}  // namespace

void gather_star(const PrimalSplit& split, int level, std::int32_t vertex, VertexStar& star) {
  const auto& topology = split.level(level);
  const auto edges = topology.GetVertexEdges(vertex);
  const auto faces = topology.GetVertexFaces(vertex);
  star.vertex = vertex;
  star.sharpness = topology.GetVertexSharpness(vertex);
  star.face_count = faces.size();
  star.edge_ends.clear();
  star.edge_sharpness.clear();
  star.face_ends.clear();
  for (int i = 0; i < edges.size(); ++i) {
    const auto ends = topology.GetEdgeVertices(edges[i]);
    star.edge_ends.push_back(ends[0] == vertex ? ends[1] : ends[0]);
    star.edge_sharpness.push_back(topology.GetEdgeSharpness(edges[i]));
  }
  if (split.scheme() == PrimalScheme::Loop || level == 0) return;
  const auto corners = topology.GetVertexFaceLocalIndices(vertex);
  for (int i = 0; i < faces.size(); ++i) {
    star.face_ends.push_back(topology.GetFaceVertices(faces[i])[(corners[i] + 2) % 4]);
  }
}

std::int32_t sector_count(const VertexStar& star) {
  const auto sharp =
      static_cast<std::int32_t>(std::ranges::count_if(star.edge_sharpness, is_infinite));
  return std::max(star.is_boundary() ? sharp - 1 : sharp, 1);
}

std::int32_t sector_of(const VertexStar& star, std::int32_t face) {
  const std::int32_t count = sector_count(star);
  if (count == 1) return 0;
  for (std::int32_t index = 0; index < count; ++index) {
    const Sector faces = sector(star, index);
    const std::int32_t place = (face - faces.first_edge + star.edge_count()) % star.edge_count();
    if (place < faces.face_count) return index;
  }
  PLANISH_ASSERT(!"every face lies in a sector");
  return -1;
}

Sector sector(const VertexStar& star, std::int32_t index) {
  const std::int32_t n = star.edge_count();
  std::int32_t edge = first_sharp_edge(star);
  for (std::int32_t passed = 0;; ++passed) {
    std::int32_t faces = 1;
    while (!is_infinite(star.edge_sharpness[(edge + faces) % n])) ++faces;
    if (passed == index) return {edge, faces};
    edge = (edge + faces) % n;
  }
}

}  // namespace planish
