#include "planish/mesh/triangle_edges.h"

#include "planish/core/assert.h"

namespace planish {

PolygonMesh polygons_of(std::span<const Triangle> triangles) {
  PolygonMesh mesh;
  mesh.face_vertices.reserve(3 * triangles.size());
  mesh.face_offsets.reserve(triangles.size() + 1);
  for (const Triangle& triangle : triangles) mesh.add_face(triangle);
  return mesh;
}

std::vector<Triangle> quads_as_triangles(std::span<const std::int32_t> corners) {
  std::vector<Triangle> triangles;
  triangles.reserve(corners.size() / 2);
  for (std::size_t i = 0; i + 3 < corners.size(); i += 4) {
    triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    triangles.push_back({corners[i], corners[i + 2], corners[i + 3]});
  }
  return triangles;
}

EdgeGroups edges_of(std::span<const Triangle> triangles, std::size_t vertex_count) {
  PolygonMesh mesh = polygons_of(triangles);
  mesh.positions.resize(vertex_count);
  return group_edges(mesh, std::vector<std::uint8_t>(triangles.size(), 1));
}

std::vector<std::int32_t> twins_of(std::span<const Triangle> triangles, std::size_t vertex_count) {
  std::vector<std::int32_t> twins(3 * triangles.size(), -1);
  edges_of(triangles, vertex_count).for_each([&](std::int32_t, std::span<const FaceSide> sides) {
    PLANISH_ASSERT(sides.size() <= 2);
    if (sides.size() < 2) return;
    twins[sides[0].corner] = sides[1].corner;
    twins[sides[1].corner] = sides[0].corner;
  });
  return twins;
}

}  // namespace planish
