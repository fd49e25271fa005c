#include "quality/facet_figures.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/mesh/angle_between.h"
#include "planish/mesh/triangle_edges.h"
#include "planish/mesh/triangulate.h"

namespace planish::quality {

FacetFigures facet_figures(const PolygonMesh& mesh, const Truth& truth) {
  constexpr double kTurn = 5, kFold = 90;
  FacetFigures figures;
  figures.facets = mesh.face_count();
  const auto count = static_cast<std::size_t>(figures.facets);
  std::vector<glm::dvec3> normals(count);  // twice the area long
  std::vector<double> angles(count), squares(count);
  parallel_each(count, 256, [&](std::size_t f) {
    const auto v = mesh.face(static_cast<std::int32_t>(f));
    const glm::dvec3 &a = mesh.positions[v[0]], &b = mesh.positions[v[1]],
                     &c = mesh.positions[v[2]];
    normals[f] = glm::cross(b - a, c - a);
    const glm::dvec3 centre = (a + b + c) / 3.0;
    const Foot foot = truth(centre);
    angles[f] = glm::degrees(angle_between(normals[f], foot.normal));
    squares[f] = glm::dot(centre - foot.point, centre - foot.point);
  });
  double area = 0;
  for (std::size_t f = 0; f < count; ++f) {
    const double size = glm::length(normals[f]);
    if (!(size > 0)) continue;
    area += size;
    figures.normals += size * angles[f] * angles[f];
    figures.distance += size * squares[f];
    if (angles[f] > kFold) figures.folded += size;
  }
  figures.normals = std::sqrt(figures.normals / area);
  figures.distance = std::sqrt(figures.distance / area);
  figures.folded /= area;

  std::vector<Triangle> triangles(count);
  for (std::size_t f = 0; f < count; ++f) {
    const auto v = mesh.face(static_cast<std::int32_t>(f));
    triangles[f] = {v[0], v[1], v[2]};
  }
  const std::vector<std::int32_t> twins = twins_of(triangles, mesh.positions.size());
  double length = 0;
  for (std::int32_t h = 0; h < std::ssize(twins); ++h) {
    const std::int32_t twin = twins[h];
    if (twin < h) continue;
    const glm::dvec3 &m = normals[h / 3], &n = normals[twin / 3];
    if (glm::dot(m, m) == 0 || glm::dot(n, n) == 0) continue;
    const Triangle& t = triangles[h / 3];
    const double part = glm::distance(mesh.positions[t[h % 3]], mesh.positions[t[(h + 1) % 3]]);
    length += part;
    if (glm::degrees(angle_between(m, n)) > kTurn) figures.turning += part;
  }
  if (length > 0) figures.turning /= length;
  return figures;
}

PolygonMesh facets_of(const SurfaceMesh& surface) {
  PolygonMesh mesh;
  mesh.positions.assign(surface.positions.begin(), surface.positions.end());
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto v = surface.face(f);
    if (v.size() == 3) {
      mesh.add_face(v);
      continue;
    }
    const auto p = [&](std::size_t i) { return mesh.positions[v[i]]; };
    const auto cut = split_quad(p(0), p(1), p(2), p(3));
    for (const std::size_t first : {0, 3})
      mesh.add_face(std::array{v[cut[first]], v[cut[first + 1]], v[cut[first + 2]]});
  }
  return mesh;
}

}  // namespace planish::quality
