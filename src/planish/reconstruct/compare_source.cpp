#include "planish/reconstruct/compare_source.h"

#include <glm/geometric.hpp>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"

namespace planish {

namespace {

// How far from its corner towards the face's middle a normal is looked up.
constexpr double kInward = 0.01;
constexpr std::size_t kCompareGrain = 256;

std::vector<Triangle> fans_of(const PolygonMesh& mesh) {
  std::vector<Triangle> triangles;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto vertices = mesh.face(f);
    for (std::size_t i = 1; i + 1 < vertices.size(); ++i) {
      triangles.push_back({vertices[0], vertices[i], vertices[i + 1]});
    }
  }
  return triangles;
}

// The nearest triangle to each corner of the surface's faces.
std::vector<std::int32_t> nearest_triangles(const SurfaceMesh& surface, const TriangleTree& tree) {
  std::vector<std::int32_t> nearest(surface.face_vertices.size());
  parallel_for(static_cast<std::size_t>(surface.face_count()), kCompareGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t f = begin; f < end; ++f) {
                   const auto vertices = surface.face(static_cast<std::int64_t>(f));
                   glm::dvec3 middle(0.0);
                   for (const std::int32_t v : vertices) middle += surface.positions[v];
                   middle /= static_cast<double>(vertices.size());
                   const auto first = vertices.data() - surface.face_vertices.data();
                   for (std::size_t i = 0; i < vertices.size(); ++i) {
                     const glm::dvec3& corner = surface.positions[vertices[i]];
                     nearest[static_cast<std::size_t>(first) + i] =
                         tree.nearest(corner + kInward * (middle - corner)).triangle;
                   }
                 }
               });
  return nearest;
}

}  // namespace

SourceComparison compare_with_source(const SurfaceMesh& surface, const PolygonMesh& source) {
  const std::vector<Triangle> triangles = fans_of(source);
  if (triangles.empty()) throw Error(ErrorCode::UnusableMesh, "the source has no faces");
  const TriangleTree tree(source.positions, triangles);
  const std::vector<std::int32_t> nearest = nearest_triangles(surface, tree);
  SourceComparison result;
  result.quality =
      surface_quality(surface, [&, next = std::size_t{0}](std::int64_t, std::int32_t) mutable {
        const Triangle& t = triangles[nearest[next++]];
        const glm::dvec3& origin = source.positions[t[0]];
        return glm::cross(source.positions[t[1]] - origin, source.positions[t[2]] - origin);
      });
  result.distances = measure_distances(surface.positions, source.positions, triangles);
  return result;
}

}  // namespace planish
