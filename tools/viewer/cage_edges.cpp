#include "cage_edges.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "planish/surface/level_one_mesh.h"
#include "planish/surface/subdivided_mesh.h"

namespace planish::viewer {
namespace {

constexpr std::uint32_t kNoPoint = ~0u;

// Each edge of the mesh once; `point_of` tells which control point a vertex is.
std::vector<std::uint32_t> edges_of(const PolygonMesh& mesh,
                                    std::span<const std::uint32_t> point_of) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t k = 0; k < face.size(); ++k) {
      const auto [a, b] = std::minmax(point_of[face[k]], point_of[face[(k + 1) % face.size()]]);
      if (b != kNoPoint) edges.emplace(a, b);
    }
  }
  std::vector<std::uint32_t> flat;
  for (const auto& [a, b] : edges) flat.insert(flat.end(), {a, b});
  return flat;
}

}  // namespace

std::vector<std::uint32_t> cage_edges(const Scene& scene, std::span<const std::int32_t> used) {
  if (scene.system.method == InterpolationMethod::Progressive) {
    std::vector<std::uint32_t> row_of(scene.mesh.positions.size());
    for (std::size_t row = 0; row < used.size(); ++row)
      row_of[used[row]] = static_cast<std::uint32_t>(row);
    return edges_of(scene.mesh, row_of);
  }
  const SubdividedMesh base(scene.mesh, scene.system.sharp);
  LevelOne level_one;
  level_one.state.resize(static_cast<std::size_t>(base.subdivision.state_size()));
  const PolygonMesh net = level_one_mesh(base, level_one);
  // Where holes cut polygons there are more vertices, which are no control points.
  std::vector<std::uint32_t> point_of(net.positions.size(), kNoPoint);
  std::iota(point_of.begin(), point_of.begin() + std::ssize(level_one.state), 0u);
  return edges_of(net, point_of);
}

}  // namespace planish::viewer
