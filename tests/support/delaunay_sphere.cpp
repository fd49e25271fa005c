#include "support/delaunay_sphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <utility>

#include "support/meshes.h"

namespace planish::test {

using glm::dvec3;
using std::int32_t;

namespace {

std::vector<dvec3> random_directions(int count, std::uint32_t seed) {
  std::uint64_t state = seed;
  const auto unit = [&] {  // splitmix64: the same on every machine
    std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
  };
  std::vector<dvec3> points;
  for (int i = 0; i < count; ++i) {
    const double z = 2 * unit() - 1, angle = 2 * std::numbers::pi * unit();
    const double radius = std::sqrt(1 - z * z);
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return points;
}

}  // namespace

PolygonMesh delaunay_sphere(int count, std::uint32_t seed) {
  const std::vector<dvec3> points = random_directions(count, seed);
  // Incremental hull: faces that see the new point make way for a fan from their rim.
  using Triangle = std::array<int32_t, 3>;
  const auto volume = [&](const Triangle& t, const dvec3& p) {
    return glm::dot(glm::cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]),
                    p - points[t[0]]);
  };
  std::vector<Triangle> faces{{0, 1, 2}, {0, 2, 1}};
  if (volume(faces[0], points[3]) > 0) std::swap(faces[0], faces[1]);
  faces = {faces[0],
           {faces[0][1], faces[0][0], 3},
           {faces[0][2], faces[0][1], 3},
           {faces[0][0], faces[0][2], 3}};
  for (int32_t p = 4; p < count; ++p) {
    std::map<std::pair<int32_t, int32_t>, bool> seen_edges;
    std::vector<Triangle> kept;
    for (const Triangle& t : faces) {
      if (volume(t, points[p]) <= 0) {
        kept.push_back(t);
        continue;
      }
      for (int i = 0; i < 3; ++i) seen_edges[{t[i], t[(i + 1) % 3]}] = true;
    }
    for (const auto& [edge, seen] : seen_edges) {
      if (!seen_edges.count({edge.second, edge.first}))
        kept.push_back({edge.first, edge.second, p});
    }
    faces = std::move(kept);
  }
  FaceList lists;
  for (const Triangle& t : faces) lists.push_back({t[0], t[1], t[2]});
  return make_mesh(points, lists);
}

}  // namespace planish::test
