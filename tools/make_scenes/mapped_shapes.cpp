// Shapes that carry texture coordinates, colours, groups and holes.
#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <utility>

#include "make_scenes/mesh_builder.h"
#include "make_scenes/shapes.h"
#include "planish/files/shared/srgb.h"

namespace planish::shapes {

namespace {

constexpr int kChartColumns = 3;
constexpr double kChartMargin = 0.05;  // of a chart's cell, so that no two charts touch

// Gives equal texture coordinates one index, in the order of their first use. The charts keep
// apart, so that no two of them share any.
void share_equal_uvs(PolygonMesh& mesh) {
  std::map<std::pair<double, double>, std::int32_t> indices;
  std::vector<glm::dvec2> uvs;
  for (std::int32_t& index : mesh.face_uvs) {
    const glm::dvec2 uv = mesh.uvs[index];
    const auto [entry, is_new] =
        indices.try_emplace({uv.x, uv.y}, static_cast<std::int32_t>(uvs.size()));
    if (is_new) uvs.push_back(uv);
    index = entry->second;
  }
  mesh.uvs = std::move(uvs);
}

int side_of(const glm::dvec3& normal) {
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
  }
  return 2 * axis + (normal[axis] > 0 ? 1 : 0);
}

// Seen from outside, u runs to the right and v upwards.
glm::dvec2 chart_point(int side, const glm::dvec3& p) {
  const int axis = side / 2;
  const double right = side % 2 == 1 ? p[(axis + 1) % 3] : -p[(axis + 1) % 3];
  const glm::dvec2 inside =
      kChartMargin + (1 - 2 * kChartMargin) * (glm::dvec2(right, p[(axis + 2) % 3]) + 1.0) / 2.0;
  const int row = side / kChartColumns, column = side % kChartColumns;
  return {(column + inside.x) / kChartColumns, (row + inside.y) / 2};
}

}  // namespace

PolygonMesh mapped_cube(std::int32_t cells) {
  PolygonMesh mesh = cube(cells);
  mesh.groups = {{"walls", "plaster"}, {"lids", "brass"}};
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    const int side = side_of(face_normal(mesh, face));
    mesh.face_groups.push_back(side / 2 == 2 ? 1 : 0);
    for (const std::int32_t v : mesh.face(face)) {
      mesh.face_uvs.push_back(static_cast<std::int32_t>(mesh.uvs.size()));
      mesh.uvs.push_back(chart_point(side, mesh.positions[v]));
    }
  }
  share_equal_uvs(mesh);
  for (const glm::dvec3& p : mesh.positions)
    mesh.colors.push_back(linear_of_srgb(glm::dvec4((p + 1.0) / 2.0, 1.0)));
  return mesh;
}

PolygonMesh cube_with_windows() {
  constexpr std::int32_t kCells = 3;
  PolygonMesh mesh = cube(kCells);
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    // The middle one of each side: no corner of it lies on an edge of the cube.
    bool is_window = true;
    for (const std::int32_t v : mesh.face(face)) {
      const glm::dvec3 p = glm::abs(mesh.positions[v]);
      is_window = is_window && p.x + p.y + p.z < 1.8;
    }
    if (is_window) mesh.hole_faces.push_back(face);
  }
  return mesh;
}

}  // namespace planish::shapes
