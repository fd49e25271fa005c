#include "planish/mesh/cusp_corners.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "planish/mesh/angle_between.h"
#include "planish/mesh/edge_groups.h"

namespace planish {

namespace {

constexpr double kCuspReach = kCuspReachDegrees * std::numbers::pi / 180;

}  // namespace

PolygonMesh with_cusp_corners(const PolygonMesh& mesh) {
  // Of a checked mesh a boundary vertex has one boundary edge that leaves it and one that comes.
  std::vector<std::int32_t> next(mesh.positions.size(), -1), previous(mesh.positions.size(), -1);
  const std::vector<std::uint8_t> all(static_cast<std::size_t>(mesh.face_count()), 1);
  group_edges(mesh, all).for_each([&](std::int32_t, std::span<const FaceSide> sides) {
    if (sides.size() > 1) return;
    const FaceSide& side = sides.front();
    const std::int32_t from = mesh.face_vertices[side.corner];
    const std::int32_t to = mesh.face_vertices[next_corner(mesh, side.face, side.corner)];
    next[from] = to;
    previous[to] = from;
  });
  std::vector<std::uint8_t> tagged(mesh.positions.size(), 0);
  for (const CornerVertex& corner : mesh.corners) {
    if (corner.sharpness >= kInfiniteSharpness) tagged[corner.vertex] = 1;
  }
  // How far the faces at a vertex reach around it: beside steep faces a tip's lips may lie over
  // each other, and the boundary turns by less.
  std::vector<double> reach(mesh.positions.size(), 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t k = 0; k < face.size(); ++k) {
      const std::int32_t v = face[k];
      if (next[v] >= 0)
        reach[v] += angle_between(
            mesh.positions[face[(k + 1) % face.size()]] - mesh.positions[v],
            mesh.positions[face[(k + face.size() - 1) % face.size()]] - mesh.positions[v]);
    }
  }
  PolygonMesh result = mesh;
  const double least_cosine = std::cos(kCuspDegrees * std::numbers::pi / 180);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (next[v] < 0 || previous[v] < 0 || tagged[v]) continue;
    const glm::dvec3 in = mesh.positions[v] - mesh.positions[previous[v]];
    const glm::dvec3 out = mesh.positions[next[v]] - mesh.positions[v];
    if (glm::dot(in, out) < least_cosine * glm::length(in) * glm::length(out) ||
        reach[v] > kCuspReach) {
      result.corners.push_back({v, kInfiniteSharpness});
    }
  }
  return result;
}

}  // namespace planish
