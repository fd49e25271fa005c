#include "planish/files/tiles/tile_mesh.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "planish/files/tiles/local_numbers.h"

namespace planish {
namespace {

// write(range of faces, their part of `values`), where a face has `per_face` of them.
template <class Write>
void for_faces(std::span<const RowRange> ranges, std::size_t per_face,
               RawVector<std::int32_t>& values, const Write& write) {
  std::size_t count = 0;
  for (const RowRange& range : ranges) count += per_face * static_cast<std::size_t>(range.count);
  values.resize(count);
  std::size_t at = 0;
  for (const RowRange& range : ranges) {
    const std::size_t part = per_face * static_cast<std::size_t>(range.count);
    write(range, std::span(values).subspan(at, part));
    at += part;
  }
}

void take_uvs(const SurfaceBlocks& blocks, std::span<const std::int32_t> uvs, SurfaceMesh& mesh) {
  mesh.uvs.resize(uvs.size());
  for (std::size_t i = 0; i < uvs.size();) {
    std::size_t end = i + 1;
    while (end < uvs.size() && uvs[end] == uvs[end - 1] + 1) ++end;
    blocks.uvs({uvs[i], static_cast<std::int64_t>(end - i)},
               std::span(mesh.uvs).subspan(i, end - i));
    i = end;
  }
}

}  // namespace

std::vector<RowRange> faces_of_tile(const TileSource& source, const PlannedTile& tile) {
  const auto of = source.plan.faces_of(tile);
  std::vector<std::int32_t> faces(of.begin(), of.end());
  std::ranges::sort(faces);
  std::vector<RowRange> ranges;
  for (const std::int32_t face : faces) {
    const RowRange range = source.blocks.faces_of(face);
    if (!ranges.empty() && ranges.back().first + ranges.back().count == range.first) {
      ranges.back().count += range.count;
    } else {
      ranges.push_back(range);
    }
  }
  return ranges;
}

TileMesh make_tile(const TileSource& source, const PlannedTile& tile, const glm::dvec3& origin) {
  const DooSabinBlocks& blocks = source.blocks;
  const SurfaceInfo& info = blocks.info();
  TileMesh made;
  SurfaceMesh& mesh = made.mesh;
  mesh.level = info.level;
  const std::vector<RowRange> faces = faces_of_tile(source, tile);
  for_faces(faces, 4, mesh.face_vertices, [&](RowRange range, std::span<std::int32_t> rows) {
    blocks.face_vertices(range, rows);
  });
  made.rows = make_local(mesh.face_vertices);
  mesh.positions.resize(made.rows.size());
  mesh.normals.resize(made.rows.size());
  RowTarget target;
  target.positions = mesh.positions;
  target.normals = mesh.normals;
  if (info.has_colors) {
    mesh.colors.resize(made.rows.size());
    target.colors = mesh.colors;
  }
  made.degenerate = blocks.rows_at(made.rows, target);
  for (glm::dvec3& position : mesh.positions) position = source.grid.snap(position) - origin;
  if (info.uv_count > 0) {
    for_faces(faces, 4, mesh.face_uvs,
              [&](RowRange range, std::span<std::int32_t> uvs) { blocks.face_uvs(range, uvs); });
    take_uvs(blocks, make_local(mesh.face_uvs), mesh);
  }
  if (info.has_groups) {
    mesh.groups = info.groups;
    for_faces(faces, 1, mesh.face_groups, [&](RowRange range, std::span<std::int32_t> groups) {
      blocks.face_groups(range, groups);
    });
  }
  return made;
}

TileBox box_of(const SurfaceMesh& mesh) {
  TileBox box{mesh.positions.front(), mesh.positions.front()};
  for (const glm::dvec3& position : mesh.positions) box.add(position);
  return box;
}

double coarser_error(const SurfaceMesh& mesh) {
  double largest = 0;
  const auto count = static_cast<std::size_t>(mesh.face_count());
  for (std::size_t first = 0; first < count; first += 4) {
    // Child j keeps corner j at its place, the other corners follow: the middle of the edge behind
    // it, the centre, the middle of the edge before it.
    const auto at = [&](std::size_t child, std::size_t place) -> const glm::dvec3& {
      return mesh.positions[mesh.face_vertices[4 * (first + child) + (child + place) % 4]];
    };
    const glm::dvec3 sum = at(0, 0) + at(1, 0) + at(2, 0) + at(3, 0);
    double farthest = glm::length(at(0, 2) - 0.25 * sum);
    for (std::size_t j = 0; j < 4; ++j) {
      const glm::dvec3 middle = 0.5 * (at(j, 0) + at((j + 1) % 4, 0));
      farthest = std::max(farthest, glm::length(at(j, 1) - middle));
    }
    const glm::dvec3 twist = at(0, 0) - at(1, 0) + at(2, 0) - at(3, 0);
    largest = std::max(largest, farthest + 0.25 * glm::length(twist));
  }
  return largest;
}

}  // namespace planish
