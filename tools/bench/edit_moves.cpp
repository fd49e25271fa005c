#include "bench/edit_moves.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <numeric>

namespace planish::bench {

glm::dvec3 way_of(std::int32_t vertex, double way) {
  const std::uint32_t lot = static_cast<std::uint32_t>(vertex) * 2'654'435'761u;
  return {lot >> 31 == 0 ? way : -way, 0, 0};
}

std::vector<std::int32_t> near_vertices(const PolygonMesh& mesh, std::int32_t vertex) {
  std::vector<std::int32_t> near(mesh.positions.size());
  std::iota(near.begin(), near.end(), 0);
  const auto distance = [&](std::int32_t v) {
    return glm::distance(mesh.positions[v], mesh.positions[vertex]);
  };
  const std::size_t many = std::min(kManyMoves, near.size());
  std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(many) - 1, near.end(),
                   [&](std::int32_t a, std::int32_t b) { return distance(a) < distance(b); });
  near.resize(many);
  return near;
}

std::vector<std::int32_t> scattered_vertices(const PolygonMesh& mesh) {
  const std::size_t count = mesh.positions.size(), many = std::min(kManyMoves, count);
  std::vector<std::int32_t> scattered(many);
  for (std::size_t i = 0; i < many; ++i) scattered[i] = static_cast<std::int32_t>(i * count / many);
  return scattered;
}

}  // namespace planish::bench
