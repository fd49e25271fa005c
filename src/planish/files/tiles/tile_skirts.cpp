#include <algorithm>
#include <unordered_map>
#include <vector>

#include "planish/files/tiles/tile_mesh.h"

namespace planish {
namespace {

// The lower vertex of each vertex that a skirt hangs from.
class SkirtVertices {
 public:
  SkirtVertices(const TileGrid& grid, double length, SurfaceMesh& mesh)
      : grid_(grid), length_(length), mesh_(mesh) {}

  std::int32_t below(std::int32_t vertex) {
    const auto [entry, is_new] =
        below_.try_emplace(vertex, static_cast<std::int32_t>(mesh_.positions.size()));
    if (is_new) {
      const glm::vec3 normal = mesh_.normals[vertex];
      const glm::dvec3 place = mesh_.positions[vertex] - length_ * glm::dvec3(normal);
      mesh_.positions.push_back(grid_.snap(place));
      mesh_.normals.push_back(normal);
      if (!mesh_.colors.empty()) mesh_.colors.push_back(glm::vec4(mesh_.colors[vertex]));
    }
    return entry->second;
  }

 private:
  const TileGrid& grid_;
  double length_;
  SurfaceMesh& mesh_;
  std::unordered_map<std::int32_t, std::int32_t> below_;
};

// Places of rows among those of the tile.
void find_all(std::span<const std::int32_t> sorted, std::vector<std::int32_t>& rows) {
  for (std::int32_t& row : rows)
    row = static_cast<std::int32_t>(std::ranges::lower_bound(sorted, row) - sorted.begin());
}

}  // namespace

void add_skirts(const TileSource& source, const PlannedTile& tile, double length, TileMesh& made) {
  SurfaceMesh& mesh = made.mesh;
  SkirtVertices skirt(source.grid, length, mesh);
  std::vector<std::int32_t> rows, uvs;
  std::vector<glm::dvec2> values;
  std::int32_t group = 0;
  const auto hang = [&](std::int32_t corner) {
    source.blocks.edge_rows(corner, rows);
    find_all(made.rows, rows);
    if (!mesh.face_uvs.empty()) {
      // Strips have texture coordinates of their own, equal to the edge's.
      source.blocks.edge_uvs(corner, uvs);
      for (std::int32_t& uv : uvs) {
        values.resize(1);
        source.blocks.uvs({uv, 1}, values);
        uv = static_cast<std::int32_t>(mesh.uvs.size());
        mesh.uvs.push_back(values[0]);
      }
    }
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
      const std::int32_t quad[] = {rows[i + 1], rows[i], skirt.below(rows[i]),
                                   skirt.below(rows[i + 1])};
      mesh.face_vertices.insert(mesh.face_vertices.end(), std::begin(quad), std::end(quad));
      if (!mesh.face_uvs.empty()) {
        const std::int32_t uv[] = {uvs[i + 1], uvs[i], uvs[i], uvs[i + 1]};
        mesh.face_uvs.insert(mesh.face_uvs.end(), std::begin(uv), std::end(uv));
      }
      if (!mesh.face_groups.empty()) mesh.face_groups.push_back(std::int32_t{group});
    }
  };
  for (const std::int32_t face : source.plan.faces_of(tile)) {
    if (!mesh.face_groups.empty()) {
      source.blocks.face_groups({source.blocks.faces_of(face).first, 1}, std::span(&group, 1));
    }
    const std::int32_t first = source.topology.first_corner(face);
    for (std::int32_t c = first; c < first + source.topology.face_size(face); ++c) {
      const std::int32_t twin = source.topology.twin(c);
      if (twin < 0) continue;
      const std::int32_t other = source.topology.face_of(twin);
      if (source.plan.face_places[other] >= 0 && !source.plan.holds(tile, other)) hang(c);
    }
  }
}

}  // namespace planish
