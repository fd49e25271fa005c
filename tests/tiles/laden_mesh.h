#pragma once

#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {

/// A random mesh with boundary, creases, darts, corners, seams, colours, groups and holes.
inline PolygonMesh laden_tiles_mesh(std::uint32_t seed) {
  PolygonMesh mesh = with_random_creases(random_open_mesh(seed), 0.1, seed);
  for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c) {
    const std::int32_t v = mesh.face_vertices[c];
    mesh.face_uvs.push_back(v % 5 == 0 ? static_cast<std::int32_t>(mesh.positions.size() + c) : v);
  }
  mesh.uvs.resize(mesh.positions.size() + mesh.face_vertices.size());
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i)
    mesh.uvs[i] = {0.25 * static_cast<double>(i % 7), 0.125 * static_cast<double>(i % 11)};
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
    mesh.colors.emplace_back(0.1f * static_cast<float>(v % 10), 0.5f, 0.25f, 1.0f);
  mesh.groups = {{"a", "red"}, {"b", "blue"}};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    mesh.face_groups.push_back(f % 2);
    if (f % 6 == 1) mesh.hole_faces.push_back(f);
  }
  return mesh;
}

}  // namespace planish::test
